// The page: shows the world, and lets its user drive, pause, step, reset, spawn, move and delete.

import {Rosbridge} from "./rosbridge.js";
import {View, compose} from "./view.js";

const NODE = "/flatland_server";
const TWIST = "geometry_msgs/Twist";
const KEYS = {
  ArrowUp: [1, 0], w: [1, 0], ArrowDown: [-1, 0], s: [-1, 0],
  ArrowLeft: [0, 1], a: [0, 1], ArrowRight: [0, -1], d: [0, -1],
};
const SPEED = {linear: 0.8, angular: 1.2};  // m/s, rad/s

const get = (id) => document.getElementById(id);
const view = new View(get("view"));
const models = new Map();  // flatland_msgs/ModelInfo by name
const frames = new Map();  // by name: {parent, pose}, as /tf has them
const bodyOf = new Map();  // "model/body" by frame
const pressed = new Set();
let isPaused = false, isSpawning = false, drag = null, isDirty = true;

const server = new Rosbridge(
  `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/${location.search}`,
  (isOpen) => { say(isOpen ? "connected" : "not connected; trying again …", !isOpen); if (isOpen) begin(); },
  (error) => say(error, true),
);

function say(text, isError = false) {
  get("status").textContent = text;
  get("status").classList.toggle("error", isError);
}

function call(service, args) {
  return server.call(service, args).then((values) => {
    say(values.message || `${service} is done`);
    return values;
  }).catch((error) => say(error.message, true));
}

function begin() {
  server.subscribe(`${NODE}/debug/walls`, (walls) => { view.setWalls(walls); isDirty = true; });
  server.subscribe(`${NODE}/models`, ({models}) => setModels(models));
  server.subscribe(`${NODE}/model_states`, (states) => setStates(states.models), {queue_length: 10});
  server.subscribe(`${NODE}/debug/models`, ({markers}) => { view.setShapes(markers); isDirty = true; },
    {throttle_rate: 500});
  server.subscribe(`${NODE}/state`, setState);
  server.subscribe("/tf", ({transforms}) => transforms.forEach(setFrame), {throttle_rate: 50, queue_length: 1});
  subscribeScans();
}

function setModels(list) {
  models.clear();
  bodyOf.clear();
  for (const model of list) {
    models.set(model.name, model);
    for (const body of model.bodies) bodyOf.set(body.frame_id, `${model.name}/${body.name}`);
  }
  for (const body of view.poses.keys()) {
    if (!models.has(body.split("/")[0])) view.poses.delete(body);
  }
  const robots = list.filter((model) => driveTopic(model));
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

const topicsOf = (model) => model.plugins.flatMap((plugin) => plugin.topics);
const driveTopic = (model) =>
  topicsOf(model).find(({type, is_published}) => type === TWIST && !is_published)?.name;

function setStates(states) {
  for (const {name, bodies} of states) {
    const model = models.get(name);
    model?.bodies.forEach((body, i) => view.poses.set(`${name}/${body.name}`, bodies[i]));
  }
  isDirty = true;
}

function setState({paused, stamp, real_time_factor: factor}) {
  isPaused = paused;
  get("pause").textContent = paused ? "Run" : "Pause";
  get("pause").classList.toggle("on", paused);
  get("step").disabled = !paused;
  const seconds = (stamp.secs + stamp.nsecs / 1e9).toFixed(1);
  get("clock").textContent = paused ? `${seconds} s, paused` : `${seconds} s, × ${factor.toFixed(2)}`;
}

// Scans

function setFrame({header, child_frame_id: child, transform: {translation, rotation: q}}) {
  const theta = Math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
  frames.set(child, {parent: header.frame_id, pose: {x: translation.x, y: translation.y, theta}});
}

/** Where a frame is: from the true pose of its body, by the transforms between the two. */
function poseOf(frame, depth = 0) {
  const body = view.poses.get(bodyOf.get(frame));
  if (body || depth > 10) return body;
  const {parent, pose} = frames.get(frame) ?? {};
  const base = parent && poseOf(parent, depth + 1);
  return base && compose(base, pose);
}

function subscribeScans() {
  const wanted = !get("scans").checked ? [] : [...models.values()].flatMap(topicsOf)
    .filter(({type, is_published}) => type === "sensor_msgs/LaserScan" && is_published)
    .map(({name}) => name);
  for (const topic of view.scans.keys()) {
    if (!wanted.includes(topic)) { server.unsubscribe(topic); view.scans.delete(topic); }
  }
  for (const topic of wanted) {
    if (!server.receivers.has(topic)) {
      server.subscribe(topic, (message) => {
        view.scans.set(topic, {message, pose: () => poseOf(message.header.frame_id)});
        isDirty = true;
      });
    }
  }
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
  else if (key === " ") call("/toggle_pause");
  else if (key === "n") stepOnce();
  else if (key === "Delete") remove();
  else if (key === "Escape") setSpawning(false);
  else return;
  event.preventDefault();
});
addEventListener("keyup", (event) => pressed.delete(event.key.length === 1 ? event.key.toLowerCase() : event.key));
addEventListener("blur", () => pressed.clear());

// Buttons

const stepOnce = () => isPaused && call("/step_world");
const remove = () => view.chosen && call("/delete_model", {name: view.chosen});

function setSpawning(value) {
  isSpawning = value;
  get("spawn").classList.toggle("on", value);
  get("view").classList.toggle("spawning", value);
  if (value) say("click where the model is to be; drag to turn it");
}

const buttons = {
  pause: () => call("/toggle_pause"),
  step: stepOnce,
  reset: () => call("/reset"),
  spawn: () => setSpawning(!isSpawning),
  delete: remove,
};
for (const [id, action] of Object.entries(buttons)) {
  get(id).onclick = () => { action(); get(id).blur(); };  // space is for the pause again
}
get("rate").onchange = () => { call("/change_rate", {rate: Number(get("rate").value)}); get("rate").blur(); };
get("robot").onchange = () => { choose(get("robot").value); get("robot").blur(); };
get("scans").onchange = subscribeScans;

function spawn({from, to}) {
  const path = get("model").value, stem = path.split("/").pop().split(".")[0];
  let number = 1;
  while (models.has(`${stem}_${number}`)) number += 1;
  const name = `${stem}_${number}`, theta = Math.atan2(to.y - from.y, to.x - from.x);
  const isTurned = Math.hypot(to.x - from.x, to.y - from.y) * view.scale > 5;
  const pose = {...from, theta: isTurned ? theta : 0};
  call("/spawn_model", {yaml_path: path, name, ns: name, pose}).then((done) => done && choose(name));
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
  if (name) choose(name);
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
    get("follow").checked = false;
  }
  isDirty = true;
};
get("view").onpointerup = () => {
  if (drag?.arrow) spawn(drag.arrow);
  else if (drag?.hasMoved) call("/move_model", {name: drag.name, pose: drag.to});
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
