// The way of a robot, and the way that its odometry believes in, from the same place.

import {compose, inverse, poseOf, seconds} from "./poses.js";

const STEP = 0.05;  // m
const MOST = 4000;  // positions

function add(way, pose) {
  const last = way.at(-1);
  if (last && Math.hypot(last.x - pose.x, last.y - pose.y) < STEP) return;
  way.push(pose);
  if (way.length > MOST) way.shift();
}

export class Trail {
  constructor() { this.clear(); }

  clear() {
    this.way = [];
    this.belief = [];
    this.anchor = null;  // the true pose and the odometry's at one time
    this.odometry = null;  // the latest message, of which the true pose is still to come
  }

  /** Notes where a body is now; its odometry's messages are in `odometry`. */
  note(poses, body) {
    const pose = poses.now.get(body);
    if (!pose) return;
    add(this.way, pose);
    const {header, pose: {pose: estimated}} = this.odometry ?? {header: null, pose: {}};
    const then = header && seconds(header.stamp) <= poses.time && poses.at(body, seconds(header.stamp));
    if (!then) return;
    const estimate = poseOf(estimated.position, estimated.orientation);
    this.anchor ??= compose(then, inverse(estimate));
    add(this.belief, compose(this.anchor, estimate));
    this.odometry = null;
  }
}
