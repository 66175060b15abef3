// Where bodies are and were: a scan is drawn at the pose that its robot had at the scan's stamp.

const MOST = 50;  // snapshots: one and a half seconds of real time
const FASTEST = 20;  // m/s: a body that is faster was moved by hand

/** A pose in a frame, given in that of the world. */
export function compose(frame, pose) {
  const cos = Math.cos(frame.theta), sin = Math.sin(frame.theta);
  return {
    x: frame.x + cos * pose.x - sin * pose.y,
    y: frame.y + sin * pose.x + cos * pose.y,
    theta: frame.theta + pose.theta,
  };
}

/** The pose that leads back: compose(pose, inverse(pose)) is none. */
export function inverse({x, y, theta}) {
  const cos = Math.cos(theta), sin = Math.sin(theta);
  return {x: -cos * x - sin * y, y: sin * x - cos * y, theta: -theta};
}

/** The pose of a position and a quaternion. */
export const poseOf = ({x, y}, q) => ({
  x, y, theta: Math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z)),
});

export const seconds = ({secs, nsecs}) => secs + nsecs / 1e9;

export class Poses {
  constructor() {
    this.now = new Map();  // by body, "model/body"
    this.snapshots = [];  // {time, poses}: now, and before
  }

  /** Adds the poses of the bodies that have moved. After going back in time, nothing is known of before. */
  add(time, moved) {
    this.now = new Map([...this.now, ...moved]);
    if (time < this.time) this.snapshots = [];
    else if (time === this.time) this.snapshots.pop();  // moved by hand, during a pause
    this.snapshots.push({time, poses: this.now});
    if (this.snapshots.length > MOST) this.snapshots.shift();
  }

  get time() { return this.snapshots.at(-1)?.time; }

  /** The pose of a body at a time up to the present one; undefined if it is not known. */
  at(body, time) {
    const next = this.snapshots.findIndex((each) => each.time >= time);
    const after = this.snapshots[next], before = this.snapshots[next - 1] ?? after;
    const from = before?.poses.get(body), to = after?.poses.get(body);
    if (!from || !to || before.time > time) return undefined;
    if (Math.hypot(to.x - from.x, to.y - from.y) > FASTEST * (after.time - before.time)) return undefined;
    const part = after.time > before.time ? (time - before.time) / (after.time - before.time) : 1;
    const turn = Math.atan2(Math.sin(to.theta - from.theta), Math.cos(to.theta - from.theta));
    return {
      x: from.x + part * (to.x - from.x),
      y: from.y + part * (to.y - from.y),
      theta: from.theta + part * turn,
    };
  }
}
