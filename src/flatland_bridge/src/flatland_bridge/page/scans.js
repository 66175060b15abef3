// The scans of all lidars, each placed where its robot was at the scan's time.

import {compose, poseOf, seconds} from "./poses.js";
import {topicsOfType} from "./driving.js";

const SCAN = "sensor_msgs/LaserScan";
const MOST_WAITING = 100;  // scans
const MOST_ROBOTS = 20;  // with more models that have lidars, only the chosen one's scans are shown

/** The namespace of a model's transforms: empty for those of /tf. */
const tfOf = ({ns, bodies: [base]}) => ns && base && !base.frame_id ? `/${ns}` : "";
const keyOf = (frame, tf) => tf ? `${tf} ${frame}` : frame;

export class Scans {
  /** server: a Rosbridge; placed: a map of {message, pose} by topic, which this fills; onPlaced: called then. */
  constructor(server, placed, onPlaced) {
    this.server = server;
    this.placed = placed;
    this.onPlaced = onPlaced;
    this.frames = new Map();  // by key: {parent, pose}, as /tf has them
    this.bodyOf = new Map();  // "model/body" by the key of its frame
    this.begin();
  }

  /** Must be called after the connection was lost. */
  begin() {
    this.topics = new Map();  // those subscribed to: the namespace of the transforms
    this.lost = new Map();  // the namespaces of transforms, by keys of scans' frames without a body
    this.waiting = [];  // {topic, message}: scans of which the poses are still to come
    this.poses = null;
  }

  /** models: those that there are; chosen: the name of one; isShown: whether scans are. */
  follow(models, chosen, isShown) {
    this.bodyOf.clear();
    this.lost.clear();
    for (const model of models) {
      for (const body of model.bodies) {
        this.bodyOf.set(keyOf(body.frame_id || body.name, tfOf(model)), `${model.name}/${body.name}`);
      }
    }
    this.followFrames("/tf_static", new Set(["", ...models.map(tfOf)]));
    const seeing = models.filter((model) => topicsOfType(model, SCAN, true).length);
    const shown = seeing.filter(({name}) => isShown && (seeing.length <= MOST_ROBOTS || name === chosen));
    const wanted = new Map(shown.flatMap((model) =>
      topicsOfType(model, SCAN, true).map((topic) => [topic, tfOf(model)])));
    for (const topic of [...this.topics.keys()].filter((each) => !wanted.has(each))) {
      this.server.unsubscribe(topic);
      this.topics.delete(topic);
      this.placed.delete(topic);
    }
    for (const [topic, tf] of [...wanted].filter(([each]) => !this.topics.has(each))) {
      this.topics.set(topic, tf);
      this.server.subscribe(topic, (message) => {
        this.waiting.push({topic, message});
        if (seconds(message.header.stamp) === this.poses?.time) this.place(this.poses);  // time stands still
      });
    }
    this.waiting = this.waiting.filter(({topic}) => this.topics.has(topic));
  }

  /** Places the scans whose time has come; subscribes to /tf while a frame of one is unknown. */
  place(poses) {
    this.poses = poses;
    this.waiting = this.waiting.filter(({topic, message}) => {
      const {frame_id, stamp} = message.header, tf = this.topics.get(topic);
      const frame = keyOf(frame_id, tf), time = seconds(stamp);
      if (time > poses.time) return true;
      const mount = this.mountOf(frame);
      if (!mount) return this.lost.set(frame, tf);
      this.lost.delete(frame);
      const base = poses.at(mount.body, time);
      if (base) this.placed.set(topic, {message, pose: compose(base, mount.pose)});
      return false;
    }).slice(-MOST_WAITING);
    this.followFrames("/tf", new Set(this.lost.values()));
    this.onPlaced();
  }

  /** Must be called after a jump in time, before `place`: forgets all scans of other times. */
  jump(time) {
    this.placed.clear();
    this.waiting = this.waiting.filter(({message}) => seconds(message.header.stamp) === time);
  }

  /** Subscribes to a topic of transforms in these namespaces, and in no others. */
  followFrames(topic, namespaces) {
    const {server} = this;
    for (const name of [...server.receivers.keys()].filter((name) => name.endsWith(topic))) {
      if (!namespaces.has(name.slice(0, -topic.length))) server.unsubscribe(name);
    }
    for (const tf of namespaces) {
      if (server.receivers.has(tf + topic)) continue;
      server.subscribe(tf + topic, (message) => this.setFrames(message, tf), {queue_length: 100});
    }
  }

  setFrames({transforms}, tf) {
    for (const {header, child_frame_id: child, transform: {translation, rotation}} of transforms) {
      const pose = poseOf(translation, rotation);
      this.frames.set(keyOf(child, tf), {parent: keyOf(header.frame_id, tf), pose});
    }
    if (this.lost.size) this.place(this.poses);
  }

  /** The body that a frame, by its key, is fixed to, and its pose on it; undefined if not known. */
  mountOf(frame, pose = {x: 0, y: 0, theta: 0}, depth = 0) {
    const body = this.bodyOf.get(frame), link = this.frames.get(frame);
    if (body) return {body, pose};
    return link && depth < 10 ? this.mountOf(link.parent, compose(link.pose, pose), depth + 1) : undefined;
  }
}
