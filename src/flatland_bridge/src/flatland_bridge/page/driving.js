// Drives a robot by the keys that are held down, or by the pad of a touch screen.

const TWIST = "geometry_msgs/Twist";
const PERIOD = 100;  // ms
const SPEEDS = [0.5, 0.5, 1.0];  // forwards and to the left [m/s], turning [rad/s]
const DIRECTIONS = {
  ArrowUp: [1, 0, 0], w: [1, 0, 0], ArrowDown: [-1, 0, 0], s: [-1, 0, 0],
  ArrowLeft: [0, 0, 1], a: [0, 0, 1], ArrowRight: [0, 0, -1], d: [0, 0, -1],
  q: [0, 1, 0], e: [0, -1, 0],
};

const topicsOf = (model) => model?.plugins.flatMap((plugin) => plugin.topics) ?? [];

/** The names of the topics of a model of one type, which the server publishes or subscribes to. */
export const topicsOfType = (model, type, isPublished) => topicsOf(model)
  .filter((topic) => topic.type === type && topic.is_published === isPublished)
  .map(({name}) => name);

/** The topic that drives a model; undefined if it has no drive. */
export const driveTopic = (model) => topicsOfType(model, TWIST, false)[0];

/** A key as it is named here, whether Shift is held or not. */
export const nameOf = ({key}) => key.length === 1 ? key.toLowerCase() : key;

export class Driving {
  /** publish(topic, type, message); topic(): of the robot that is driven, if any. */
  constructor(publish, topic) {
    this.publish = publish;
    this.topic = topic;
    this.isSlow = false;
    this.held = new Set();
    this.driven = null;  // the topic of the last command, unless that was to stop
    setInterval(() => this.command(), PERIOD);
    addEventListener("keyup", (event) => this.release(nameOf(event)));
    addEventListener("blur", () => this.stop());
    addEventListener("pagehide", () => this.stop());
  }

  /** Returns whether a key drives. */
  press(key) {
    if (DIRECTIONS[key]) this.held.add(key);
    return key in DIRECTIONS;
  }

  release(key) { this.held.delete(key); }

  stop() {
    this.held.clear();
    this.command();
  }

  /** Sends a command while keys are held, and zero once when the last is released or the robot another one. */
  command() {
    const topic = this.topic(), isHeld = this.held.size > 0;
    if (this.driven && (this.driven !== topic || !isHeld)) {
      this.publish(this.driven, TWIST, {});
      this.driven = null;
    }
    if (!topic || !isHeld) return;
    const [x, y, turn] = SPEEDS.map((speed, i) => {
      const sum = [...this.held].reduce((total, key) => total + DIRECTIONS[key][i], 0);
      return Math.sign(sum) * speed * (this.isSlow ? 0.5 : 1);
    });
    this.publish(topic, TWIST, {linear: {x, y}, angular: {z: turn}});
    this.driven = topic;
  }
}
