// The page: shows the world, and lets its user drive, pause, step, reset, spawn, move and delete.

import {Poses, compose, seconds} from "./poses.js";
import {Rosbridge} from "./rosbridge.js";
import {View} from "./view.js";

const NODE = "/flatland_server";
const TWIST = "geometry_msgs/Twist";
const KEYS = {
  ArrowUp: [1, 0], w: [1, 0], ArrowDown: [-1, 0], s: [-1, 0],
  ArrowLeft: [0, 1], a: [0, 1], ArrowRight: [0, -1], d: [0, -1],
};
const SPEED = {linear: 0.8, angular: 1.2};  // m/s, rad/s
const MOST_WAITING = 100;  // scans

const get = (id) => document.getElementById(id);
const view = new View(get("view"));
const models = new Map();  // flatland_msgs/ModelInfo by name
const frames = new Map();  // by key: {parent, pose}, as /tf has them
const bodyOf = new Map();  // "model/body" by the key of its frame
const pressed = new Set();
const scanTopics = new Map();  // those subscribed to: the namespace of the transforms
const lost = new Map();  // the namespaces of transforms, by keys of scans' frames without a body
let poses = new Poses();
let waiting = [];  // {topic, message}: scans of which the poses are still to come
let isPaused = false, isSpawning = false, drag = null, isDirty = true;

const server = new Rosbridge(
  `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/${location.search}`,
  (isOpen) => isOpen ? begin() : end(),
  (error) => say(error, "error"),
);

/** kind: "error", "warning" or "". */
function say(text, kind = "") {
  get("status").textContent = text;
  get("status").className = kind;
}

/** Shows a text above the world until it is over. */
function announce(text) {
  get("banner").textContent = text;
}

/** Calls a service, and says what it has done, or its warning. */
function call(service, args, done) {
  return server.call(service, args).then((values) => {
    say(values.message || done, values.message ? "warning" : "");
    return values;
  }).catch((error) => say(error.message, "error"));
}

function begin() {
  say("connected");
  poses = new Poses();
  scanTopics.clear();
  server.subscribe(`${NODE}/debug/walls`, (walls) => { view.setWalls(walls); isDirty = true; });
  server.subscribe(`${NODE}/models`, ({models}) => setModels(models));
  server.subscribe(`${NODE}/model_states`, setStates, {queue_length: 10});
  server.subscribe(`${NODE}/debug/models`, ({markers}) => { view.setShapes(markers); isDirty = true; },
    {throttle_rate: 500});
  server.subscribe(`${NODE}/state`, setState);
  followFrames("/tf_static", new Set([""]));
  subscribeScans();
}

function end() {
  announce("Not connected to the server. Trying again …");
  say("");
}

function setModels(list) {
  models.clear();
  bodyOf.clear();
  lost.clear();
  for (const model of list) {
    models.set(model.name, model);
    for (const body of model.bodies) {
      bodyOf.set(keyOf(body.frame_id || body.name, tfOf(model)), `${model.name}/${body.name}`);
    }
  }
  followFrames("/tf_static", new Set(["", ...list.map(tfOf)]));
  for (const body of poses.now.keys()) {
    if (!models.has(body.split("/")[0])) poses.now.delete(body);
  }
  const robots = list.filter((model) => driveTopic(model));
  view.robots = robots.map(({name, bodies: [base]}) => ({
    name, body: `${name}/${base.name}`,
    radius: Math.hypot(Math.max(-base.min_x, base.max_x), Math.max(-base.min_y, base.max_y)),
  }));
  fill(get("robot"), robots.map(({name}) => [name, name]));
  fill(get("model"), [...new Set(list.map((model) => model.yaml_path).filter(Boolean))]
    .map((path) => [path, path.split("/").pop()]));
  choose(models.has(view.chosen) ? view.chosen : get("robot").value);
  subscribeScans();
}

function fill(select, options) {
  const before = select.value;
  select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
  if (options.some(([value]) => value === before)) select.value = before;
}

function choose(name) {
  view.chosen = name || null;
  if (name) get("robot").value = name;
  get("delete").disabled = !name;
  isDirty = true;
}

function chooseByHand(name) {
  choose(name);
  say(driveTopic(models.get(name)) ? `the keys drive ${name}` : `${name} has no drive`);
}

const topicsOf = (model) => model.plugins.flatMap((plugin) => plugin.topics);
const driveTopic = (model) =>
  topicsOf(model).find(({type, is_published}) => type === TWIST && !is_published)?.name;

function setStates({stamp, models: states}) {
  const moved = states.flatMap(({name, bodies}) =>
    (models.get(name)?.bodies ?? []).map((body, i) => [`${name}/${body.name}`, bodies[i]]));
  if (seconds(stamp) < poses.time) { view.scans.clear(); waiting = []; }  // a reset
  poses.add(seconds(stamp), moved);
  view.poses = poses.now;
  placeScans();
  isDirty = true;
}

function setState({paused, stamp, real_time_factor: factor}) {
  isPaused = paused;
  announce(paused ? "Paused: space goes on, N makes a step" : "");
  get("pause").textContent = paused ? "Run" : "Pause";
  get("pause").classList.toggle("on", paused);
  get("step").disabled = !paused;
  const time = `${seconds(stamp).toFixed(1)} s`;
  get("clock").textContent = paused ? `${time}, paused` : `${time}, × ${factor.toFixed(2)}`;
}

// Scans

/** The namespace of a model's transforms: empty for those of /tf. */
const tfOf = ({ns, bodies: [base]}) => ns && base && !base.frame_id ? `/${ns}` : "";
const keyOf = (frame, tf) => tf ? `${tf} ${frame}` : frame;

/** Subscribes to a topic of transforms in these namespaces, and in no others. */
function followFrames(topic, namespaces) {
  for (const name of [...server.receivers.keys()].filter((name) => name.endsWith(topic))) {
    if (!namespaces.has(name.slice(0, -topic.length))) server.unsubscribe(name);
  }
  for (const tf of namespaces) {
    if (server.receivers.has(tf + topic)) continue;
    server.subscribe(tf + topic, (message) => setFrames(message, tf), {queue_length: 100});
  }
}

function setFrames({transforms}, tf) {
  for (const {header, child_frame_id: child, transform: {translation, rotation: q}} of transforms) {
    const theta = Math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
    const pose = {x: translation.x, y: translation.y, theta};
    frames.set(keyOf(child, tf), {parent: keyOf(header.frame_id, tf), pose});
  }
}

/** The body that a frame, by its key, is fixed to, and its pose on it; undefined if not known. */
function mountOf(frame, pose = {x: 0, y: 0, theta: 0}, depth = 0) {
  const body = bodyOf.get(frame), link = frames.get(frame);
  if (body) return {body, pose};
  return link && depth < 10 ? mountOf(link.parent, compose(link.pose, pose), depth + 1) : undefined;
}

/** Places the scans whose time has come; subscribes to /tf while a frame of one is unknown. */
function placeScans() {
  const isDue = ({message}) => seconds(message.header.stamp) <= poses.time;
  for (const {topic, message} of waiting.filter(isDue)) {
    const {frame_id, stamp} = message.header, tf = scanTopics.get(topic);
    const frame = keyOf(frame_id, tf), mount = mountOf(frame);
    if (mount) lost.delete(frame); else lost.set(frame, tf);
    const base = mount && poses.at(mount.body, seconds(stamp));
    if (base) view.scans.set(topic, {message, pose: compose(base, mount.pose)});
  }
  waiting = waiting.filter((scan) => !isDue(scan)).slice(-MOST_WAITING);
  followFrames("/tf", new Set(lost.values()));
}

function subscribeScans() {
  const wanted = new Map(!get("scans").checked ? [] : [...models.values()].flatMap((model) =>
    topicsOf(model)
      .filter(({type, is_published}) => type === "sensor_msgs/LaserScan" && is_published)
      .map(({name}) => [name, tfOf(model)])));
  for (const topic of [...scanTopics.keys()].filter((each) => !wanted.has(each))) {
    server.unsubscribe(topic);
    scanTopics.delete(topic);
    view.scans.delete(topic);
  }
  for (const [topic, tf] of [...wanted].filter(([each]) => !scanTopics.has(each))) {
    server.subscribe(topic, (message) => waiting.push({topic, message}));
    scanTopics.set(topic, tf);
  }
  waiting = waiting.filter(({topic}) => scanTopics.has(topic));
  isDirty = true;
}

// Driving: a command many times a second, and zero once when the last key is released

let wasDriving = false;
setInterval(() => {
  const model = models.get(view.chosen), topic = model && driveTopic(model);
  if (!topic || (!pressed.size && !wasDriving)) return;
  let [forward, turn] = [0, 0];
  for (const key of pressed) { forward += KEYS[key][0]; turn += KEYS[key][1]; }
  server.publish(topic, TWIST, {
    linear: {x: Math.sign(forward) * SPEED.linear}, angular: {z: Math.sign(turn) * SPEED.angular},
  });
  wasDriving = pressed.size > 0;
}, 100);

addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.target instanceof HTMLSelectElement) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (KEYS[key]) pressed.add(key);
  else if (key === " ") pauseOrRun();
  else if (key === "n") stepOnce();
  else if (key === "Delete") remove();
  else if (key === "Escape") setSpawning(false);
  else return;
  event.preventDefault();
});
addEventListener("keyup", (event) => pressed.delete(event.key.length === 1 ? event.key.toLowerCase() : event.key));
addEventListener("blur", () => pressed.clear());

// Buttons

const pauseOrRun = () => isPaused ? call("/resume", {}, "running") : call("/pause", {}, "paused");
const stepOnce = () => isPaused && call("/step_world", {}, "a step of 0.1 s");

function remove() {
  const name = view.chosen;
  if (name) call("/delete_model", {name}, `${name} is deleted`);
}

function setSpawning(value) {
  isSpawning = value;
  get("spawn").classList.toggle("on", value);
  get("view").classList.toggle("spawning", value);
  if (value) say("click where the model is to be; drag to turn it");
}

const buttons = {
  pause: pauseOrRun,
  step: stepOnce,
  reset: () => call("/reset", {}, "the world is as it was loaded"),
  spawn: () => setSpawning(!isSpawning),
  delete: remove,
};
for (const [id, action] of Object.entries(buttons)) {
  get(id).onclick = () => { action(); get(id).blur(); };  // space is for the pause again
}
get("rate").onchange = () => {
  const rate = Number(get("rate").value);
  call("/change_rate", {rate}, `${rate} s are simulated in a second`);
  get("rate").blur();
};
get("robot").onchange = () => { chooseByHand(get("robot").value); get("robot").blur(); };
get("scans").onchange = subscribeScans;

function spawn({from, to}) {
  const path = get("model").value, stem = path.split("/").pop().split(".")[0];
  let number = 1;
  while (models.has(`${stem}_${number}`)) number += 1;
  const name = `${stem}_${number}`, theta = Math.atan2(to.y - from.y, to.x - from.x);
  const isTurned = Math.hypot(to.x - from.x, to.y - from.y) * view.scale > 5;
  const pose = {...from, theta: isTurned ? theta : 0};
  call("/spawn_model", {yaml_path: path, name, ns: name, pose}, `${name} is spawned`)
    .then((done) => done && choose(name));
  setSpawning(false);
}

// The mouse: spawns, moves a model, or moves the view

function modelAt({x, y}) {
  for (const model of models.values()) {
    for (const body of model.bodies) {
      const pose = view.poses.get(`${model.name}/${body.name}`);
      if (!pose) continue;
      const [dx, dy] = [x - pose.x, y - pose.y];
      const [cos, sin] = [Math.cos(pose.theta), Math.sin(pose.theta)];
      const [u, v] = [cos * dx + sin * dy, cos * dy - sin * dx];
      if (u >= body.min_x && u <= body.max_x && v >= body.min_y && v <= body.max_y) return model.name;
    }
  }
  return null;
}

get("view").onpointerdown = (event) => {
  const at = view.toWorld(event);
  get("view").setPointerCapture(event.pointerId);
  if (isSpawning) {
    drag = {arrow: {from: at, to: at}};
    return;
  }
  const name = modelAt(at);
  if (name) chooseByHand(name);
  drag = {name, at, hasMoved: false};
};
get("view").onpointermove = (event) => {
  if (!drag) return;
  const at = view.toWorld(event);
  if (drag.arrow) {
    view.arrow = drag.arrow = {from: drag.arrow.from, to: at};
  } else if (drag.name) {
    const base = view.poses.get(`${drag.name}/${models.get(drag.name)?.bodies[0].name}`);
    drag.to = {x: at.x, y: at.y, theta: base?.theta ?? 0};
    drag.hasMoved ||= Math.hypot(at.x - drag.at.x, at.y - drag.at.y) * view.scale > 5;
    if (drag.hasMoved) view.arrow = {from: drag.to, to: drag.to};
  } else {
    view.center.x += drag.at.x - at.x;
    view.center.y += drag.at.y - at.y;
    view.isMoved = true;
    get("follow").checked = false;
  }
  isDirty = true;
};
get("view").onpointerup = () => {
  if (drag?.arrow) spawn(drag.arrow);
  else if (drag?.hasMoved) call("/move_model", {name: drag.name, pose: drag.to}, `${drag.name} is moved`);
  drag = view.arrow = null;
  isDirty = true;
};
get("view").onwheel = (event) => {
  view.zoom(event, Math.exp(-event.deltaY / 500));
  isDirty = true;
  event.preventDefault();
};

function draw() {
  const model = models.get(view.chosen);
  const pose = model && view.poses.get(`${model.name}/${model.bodies[0].name}`);
  if (get("follow").checked && pose) view.center = {x: pose.x, y: pose.y};
  if (isDirty) view.draw();
  isDirty = get("follow").checked;
  requestAnimationFrame(draw);
}
draw();
