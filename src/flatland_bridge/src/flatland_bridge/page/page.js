// The page: shows the world and its past, and lets its user drive, spawn, move, delete, undo and save.

import {Driving, driveTopic, nameOf, topicsOfType} from "./driving.js";
import {Poses, seconds} from "./poses.js";
import {Rosbridge} from "./rosbridge.js";
import {Scans} from "./scans.js";
import {Trail} from "./trail.js";
import {View} from "./view.js";

const NODE = "/flatland_server";
const RATES = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];  // simulated seconds per second
const STEP = 0.1;  // s
const CLICK = 5;  // px: a pointer that moves farther is dragging

const get = (id) => document.getElementById(id);
const view = new View(get("view"));
const models = new Map();  // flatland_msgs/ModelInfo by name
const trail = new Trail();
const server = new Rosbridge(
  `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/${location.search}`,
  (isOpen) => isOpen ? begin() : end(),
  (error) => say(error, "error"),
);
const scans = new Scans(server, view.scans, () => { isDirty = true; });
const driving = new Driving(
  (topic, type, message) => server.publish(topic, type, message),
  () => isInPast() ? undefined : driveTopic(models.get(view.chosen)),
);
let poses = new Poses(), services = new Set(), odometry = null;  // odometry: the topic for the trail
let state = {paused: false, time: 0, begin: 0, end: 0};
let isScanMissed = false;  // whether scans were chosen, which may not come while time stands still
let sought = null, isSeeking = false;  // a time to seek; whether a call does it
let isSpawning = false, drag = null, isDirty = true;
let followed = new URLSearchParams(location.search).get("follow");  // once it is there

/** True while an earlier time is shown: the run can go on from there, as another one. */
const isInPast = () => state.paused && state.time < state.end;

/** kind: "error", "warning" or "". */
function say(text, kind = "") {
  Object.assign(get("status"), {textContent: text, title: text, className: kind});
}

/** Shows a text above the world until it is over. */
function announce(text) {
  get("banner").textContent = text;
}

/** Calls a service, and says what it has done, or its warning; without `done`, its own words. */
function call(service, args, done) {
  return server.call(service, args).then((values) => {
    if (done === undefined) say(values.message);
    else say(values.message || done, values.message ? "warning" : "");
    return values;
  }).catch((error) => say(error.message, "error"));
}

function begin() {
  say("connected");
  poses = new Poses();
  scans.begin();
  trail.clear();
  odometry = null;
  server.subscribe(`${NODE}/debug/walls`, (walls) => { view.setWalls(walls); isDirty = true; });
  server.subscribe(`${NODE}/models`, ({models}) => setModels(models));
  server.subscribe(`${NODE}/model_states`, setStates, {queue_length: 10});
  server.subscribe(`${NODE}/debug/models`, ({markers}) => { view.setShapes(markers); isDirty = true; },
    {throttle_rate: 500});
  server.subscribe(`${NODE}/state`, setState);
  server.call("/rosapi/services").then((values) => {
    services = new Set(values.services);
    get("save").disabled = !services.has("/save_world");
  });
}

function end() {
  announce("Not connected to the simulation. Trying again …");
  say("");
}

// Models

function setModels(list) {
  models.clear();
  for (const model of list) models.set(model.name, model);
  for (const body of poses.now.keys()) {
    if (!models.has(body.split("/")[0])) poses.now.delete(body);
  }
  const robots = list.filter(driveTopic);
  view.models = list.map((model) => {
    const {name, bodies: [base]} = model;
    const radius = Math.hypot(Math.max(-base.min_x, base.max_x), Math.max(-base.min_y, base.max_y));
    return {name, body: `${name}/${base.name}`, radius, isRobot: robots.includes(model)};
  });
  fill(get("robot"), robots.map(({name}) => [name, name]));
  fill(get("model"), [...new Set(list.map((model) => model.yaml_path).filter(Boolean))]
    .map((path) => [path, path.split("/").pop().replace(/(\.model)?\.ya?ml$/, "")]));
  get("spawn").disabled = !get("model").value;
  const failed = list.flatMap(({name, plugins}) =>
    plugins.filter((plugin) => plugin.has_failed).map((plugin) => `${name}/${plugin.name}`));
  get("failed").textContent = failed.length ? `switched off after an error: ${failed.join(", ")}` : "";
  choose(models.has(view.chosen) ? view.chosen : get("robot").value);
  if (models.has(followed)) {
    choose(followed);
    follow(true);
    followed = null;
  }
}

function fill(select, options) {
  const before = select.value;
  select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
  if (options.some(([value]) => value === before)) select.value = before;
}

function choose(name) {
  if (view.chosen !== (name || null)) trail.clear();
  view.chosen = name || null;
  if (name) get("robot").value = name;
  get("delete").disabled = !name;
  get("pose").textContent = "";
  show();
}

function chooseByHand(name) {
  choose(name);
  say(driveTopic(models.get(name)) ? `the keys drive ${name}` : `${name} has no drive`);
}

function chooseNext(step) {
  const names = [...get("robot").options].map(({value}) => value);
  if (!names.length) return;
  chooseByHand(names[(names.indexOf(view.chosen) + step + names.length) % names.length]);
  follow(true);
}

function follow(isFollowing) {
  get("follow").checked = isFollowing;
  if (isFollowing) view.comeNear();
  isDirty = true;
}

/** Subscribes to what is shown: scans, and the odometry of the chosen model for its trail. */
function show() {
  const model = models.get(view.chosen), hasTrail = get("trail").checked;
  scans.follow([...models.values()], view.chosen, get("scans").checked);
  const topic = hasTrail
    ? topicsOfType(model, "nav_msgs/Odometry", true).find((name) => !name.endsWith("ground_truth")) : undefined;
  if (odometry && odometry !== topic) server.unsubscribe(odometry);
  if (topic && odometry !== topic) server.subscribe(topic, (message) => { trail.odometry = message; });
  odometry = topic;
  if (!hasTrail) trail.clear();
  view.trails = [trail.way, trail.belief];
  view.showsNames = get("names").checked;
  isDirty = true;
}

const baseOf = (name) => `${name}/${models.get(name)?.bodies[0].name}`;

function setStates({stamp, models: states}) {
  const time = seconds(stamp);
  const moved = states.flatMap(({name, bodies}) =>
    (models.get(name)?.bodies ?? []).map((body, i) => [`${name}/${body.name}`, bodies[i]]));
  if (time < poses.time) {  // a reset, or a time in the past
    scans.jump(time);
    trail.clear();
  }
  poses.add(time, moved);
  view.poses = poses.now;
  scans.place(poses);
  if (get("trail").checked && view.chosen) trail.note(poses, baseOf(view.chosen));
  view.trails = [trail.way, trail.belief];
  const chosen = states.find(({name}) => name === view.chosen);
  if (chosen) showPose(chosen);
  isDirty = true;
}

function showPose({name, pose: {x, y, theta}, twist: {linear, angular}}) {
  const number = (value, digits = 2) => value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1");
  const aside = Math.abs(linear.y) < 5e-3 ? "" : `, ${number(linear.y)}`;
  get("pose").textContent = `${name}   x ${number(x)}  y ${number(y)}  yaw ${number(theta * 180 / Math.PI, 0)}°   `
    + `${number(linear.x)}${aside} m/s  ${number(angular.z)} rad/s`;
}

// Time

function setState({paused, stamp, rate, real_time_factor: factor, history_begin, history_end, edits, ...revertible}) {
  state = {paused, time: seconds(stamp), begin: seconds(history_begin), end: seconds(history_end)};
  const hasPast = state.end > state.begin;
  announce(!paused ? "" : isInPast()
    ? `${state.time.toFixed(1)} s, in the past: Run (space) goes on from here, as another run`
    : "Paused: Run (space) goes on");
  get("pause").textContent = paused ? "Run" : "Pause";
  get("pause").classList.toggle("on", paused);
  get("clock").textContent = `${state.time.toFixed(1)} s${paused ? ", paused" : `, × ${factor.toFixed(2)}`}`;
  get("save").textContent = edits ? `Save * ${edits}` : "Save";
  for (const id of ["undo", "redo"]) {  // the names of the edits, if the server tells
    get(id).disabled = !services.has(`/${id}`) || revertible[id] === "";
    get(id).title = `${revertible[id] || "the last change of models"} (${id === "undo" ? "Ctrl+Z" : "Ctrl+Shift+Z"})`;
  }
  setRate(rate);
  get("timeline").hidden = !hasPast;
  get("latest").disabled = !isInPast();
  const slider = get("slider");
  if (hasPast && !isSeeking && document.activeElement !== slider) {
    Object.assign(slider, {min: state.begin, max: state.end, value: state.time});
  }
  measure();
}

/** While time stands still, sensors measure when it is sought: after the first state that tells the past. */
function measure() {
  if (state.end <= state.begin) return;
  if (isScanMissed && state.paused) seek(state.time);
  isScanMissed = false;
}

/** rate: null if it is infinite, as JSON has it. */
function setRate(rate) {
  const value = String(rate ?? "max"), select = get("rate");
  if (select.value === value) return;
  const rates = RATES.includes(rate) ? RATES : [...RATES, rate ?? "max"].sort((a, b) => a - b);
  fill(select, rates.map((each) => [each, each]));
  select.value = value;
}

function changeRate(rate) {
  if (rate) call("/change_rate", {rate}, `${rate} s are simulated in a second`);
}

/** Pauses, and shows the world at a time [s], or the nearest one; of several calls the last one counts. */
async function seek(time) {
  if (state.end <= state.begin) return;
  sought = state.time = Math.min(Math.max(time, state.begin), state.end);
  if (isSeeking) return;
  isSeeking = true;
  while (sought !== null) {
    const next = sought;
    sought = null;
    trail.clear();
    await call("/seek", {time: next}, "");
  }
  isSeeking = false;
}

const pauseOrRun = () => call(state.paused ? "/resume" : "/pause", {}, "");

async function stepBy(service, request, what) {
  if (isInPast()) return seek(state.time + STEP);
  if (!state.paused) await call("/pause", {}, "");
  return call(service, request, what);
}
const goOn = () => stepBy("/step_world", {}, `a step of ${STEP} s`);

// Changes of the world

function spawn({from, to}) {
  const path = get("model").value, stem = path.split("/").pop().split(".")[0];
  let number = 1;
  while (models.has(`${stem}_${number}`)) number += 1;
  const name = `${stem}_${number}`, theta = Math.atan2(to.y - from.y, to.x - from.x);
  const isTurned = Math.hypot(to.x - from.x, to.y - from.y) * view.scale > CLICK;
  const pose = {...from, theta: isTurned ? theta : 0};
  call("/spawn_model", {yaml_path: path, name, ns: name, pose}, `${name} is spawned`)
    .then((done) => done && choose(name));
  setSpawning(false);
}

function setSpawning(value) {
  isSpawning = value;
  get("spawn").classList.toggle("on", value);
  get("view").classList.toggle("spawning", value);
  if (value) say("click where the model is to be; drag to turn it");
}

function remove() {
  const name = view.chosen;
  if (name) call("/delete_model", {name}, `${name} is deleted`);
}

function undo(name) {
  if (services.has(`/${name}`)) call(`/${name}`, {});
}

/** Saves in the world's file, or if that cannot be, in a copy. */
async function save(isCopy) {
  if (get("save").disabled) return;
  if (!isCopy && await call("/save_world", {path: ""})) return;
  const path = prompt(`${isCopy ? "" : `${get("status").textContent}\n\n`}Save a copy as:`, "my_world.yaml");
  if (path) call("/save_world", {path});
}

function savePicture() {
  view.draw();
  get("view").toBlob((blob) => {
    const link = Object.assign(document.createElement("a"), {
      href: URL.createObjectURL(blob), download: `flatland_${state.time.toFixed(1)}.png`,
    });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    say(`saved ${link.download}`);
  });
}

// Light and dark

const systemLook = matchMedia("(prefers-color-scheme: dark)");

function setLook() {
  const chosen = localStorage.getItem("look");
  view.isDark = chosen ? chosen === "dark" : systemLook.matches;
  document.documentElement.style.colorScheme = view.isDark ? "dark" : "light";
  get("look").textContent = view.isDark ? "Light" : "Dark";
  isDirty = true;
}
systemLook.onchange = setLook;
setLook();

function changeLook() {
  localStorage.setItem("look", view.isDark ? "light" : "dark");
  setLook();
}

// Buttons and keys

function toggle(id) {
  get(id).checked = !get(id).checked;
  get(id).onchange();
}

const showKeys = () => get("keys").open ? get("keys").close() : get("keys").showModal();
/** Leaves spawning, following, or the view: then Tab goes through the buttons. */
function leave() {
  if (isSpawning) setSpawning(false);
  else if (get("follow").checked) follow(false);
  else get("view").blur();
}

const showAll = () => { view.showAll(); follow(false); };
const latest = () => seek(state.end);
const buttons = {
  pause: pauseOrRun, step: goOn, reset: () => call("/reset", {}, "the world is as it was loaded"),
  spawn: () => setSpawning(!isSpawning), delete: remove, undo: () => undo("undo"), redo: () => undo("redo"),
  save: () => save(false), all: showAll, picture: savePicture, look: changeLook, help: showKeys, latest,
};
for (const [id, action] of Object.entries(buttons)) {
  get(id).onclick = () => { action(); get("view").focus(); };  // whose keys are the page's again
}
get("rate").onchange = () => { changeRate(Number(get("rate").value)); get("view").focus(); };
get("robot").onchange = () => { chooseByHand(get("robot").value); get("view").focus(); };
get("follow").onchange = () => follow(get("follow").checked);
for (const id of ["names", "trail"]) get(id).onchange = show;
get("scans").onchange = () => {
  show();
  isScanMissed = get("scans").checked;
  measure();
};
get("slider").oninput = () => seek(Number(get("slider").value));
get("slider").onchange = () => get("view").focus();
for (const button of get("pad").children) {
  button.onpointerdown = () => driving.press(button.dataset.key);
  for (const kind of ["pointerup", "pointerleave", "pointercancel"]) {
    button.addEventListener(kind, () => driving.release(button.dataset.key));
  }
  button.oncontextmenu = () => false;  // of a long touch
}

const actions = {
  " ": pauseOrRun, ".": goOn, ",": () => seek(state.time - STEP), r: buttons.reset,
  F10: () => stepBy("/step", {steps: 1}, "one step"),
  "+": () => changeRate(RATES.find((rate) => rate > Number(get("rate").value))),
  "-": () => changeRate(RATES.findLast((rate) => rate < Number(get("rate").value))),
  f: () => toggle("follow"), l: () => toggle("scans"), n: () => toggle("names"), t: () => toggle("trail"),
  Home: showAll, Delete: remove, F1: showKeys, h: showKeys, Tab: () => chooseNext(1),
  "Shift+Tab": () => chooseNext(-1), Escape: leave,
  "Ctrl+z": buttons.undo, "Ctrl+Shift+z": buttons.redo, "Ctrl+s": buttons.save, "Ctrl+Shift+s": () => save(true),
  "Ctrl+p": savePicture, "Alt+ArrowLeft": () => seek(state.time - 10), "Alt+ArrowRight": () => seek(state.time + 10),
  "Alt+Shift+ArrowLeft": () => seek(state.time - 1), "Alt+Shift+ArrowRight": () => seek(state.time + 1),
  "Alt+End": latest,
};

addEventListener("keydown", (event) => {
  const {target, ctrlKey, metaKey, altKey, shiftKey} = event, name = nameOf(event);
  driving.isSlow = shiftKey;
  if (target instanceof HTMLSelectElement || get("keys").open) return;
  if (name === "Tab" && target !== get("view")) return;  // goes through the buttons
  const isPlain = !(ctrlKey || metaKey || altKey);
  const modifiers = `${ctrlKey || metaKey ? "Ctrl+" : ""}${altKey ? "Alt+" : ""}`;
  const action = actions[`${modifiers}${shiftKey ? "Shift+" : ""}${name}`] ?? (isPlain && actions[name]);
  if (isPlain && driving.press(name)) event.preventDefault();
  else if (action) {
    event.preventDefault();
    action();
  }
});
addEventListener("keyup", (event) => { driving.isSlow = event.shiftKey; });

// Pointers: one spawns, moves or turns a model, or moves the view; two zoom

const pointers = new Map();  // by id: {offsetX, offsetY}

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

/** The middle of the two pointers on the view, and their distance [px]. */
function pinch() {
  const [a, b] = pointers.values();
  return {
    offsetX: (a.offsetX + b.offsetX) / 2, offsetY: (a.offsetY + b.offsetY) / 2,
    distance: Math.hypot(a.offsetX - b.offsetX, a.offsetY - b.offsetY),
  };
}

function pan(from, to) {
  view.center.x += from.x - to.x;
  view.center.y += from.y - to.y;
  view.isMoved = true;
  get("follow").checked = false;
}

get("view").onpointerdown = (event) => {
  const at = view.toWorld(event);
  get("view").setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, event);
  if (pointers.size > 1) {
    drag = view.arrow = null;
    return;
  }
  if (isSpawning) {
    drag = {arrow: {from: at, to: at}};
    return;
  }
  const name = modelAt(at);
  if (name) chooseByHand(name);
  drag = {name, at, turns: event.shiftKey, hasMoved: false};
};
get("view").onpointermove = (event) => {
  if (pointers.size === 2 && pointers.has(event.pointerId)) {
    const before = pinch();
    pointers.set(event.pointerId, event);
    const after = pinch();
    pan(view.toWorld(before), view.toWorld(after));
    view.zoom(after, after.distance / Math.max(before.distance, 1));
    isDirty = true;
  }
  if (!drag) return;
  const at = view.toWorld(event), base = view.poses.get(baseOf(drag.name));
  if (drag.arrow) {
    view.arrow = drag.arrow = {from: drag.arrow.from, to: at};
  } else if (base) {
    drag.hasMoved ||= Math.hypot(at.x - drag.at.x, at.y - drag.at.y) * view.scale > CLICK;
    drag.to = drag.turns ? {...base, theta: Math.atan2(at.y - base.y, at.x - base.x)} : {...at, theta: base.theta};
    if (drag.hasMoved) view.arrow = drag.turns ? {from: base, to: at} : {from: drag.to, to: drag.to};
  } else {
    pan(drag.at, at);
  }
  isDirty = true;
};
get("view").onpointerup = get("view").onpointercancel = (event) => {
  pointers.delete(event.pointerId);
  const {arrow, name, to, turns, hasMoved} = drag ?? {};
  if (event.type === "pointerup" && arrow) spawn(arrow);
  else if (event.type === "pointerup" && hasMoved) {
    call("/move_model", {name, pose: to}, `${name} is ${turns ? "turned" : "moved"}`).then(() => trail.clear());
  }
  drag = view.arrow = null;
  isDirty = true;
};
get("view").onwheel = (event) => {
  view.zoom(event, Math.exp(-event.deltaY / 500));
  isDirty = true;
  event.preventDefault();
};

function draw() {
  const pose = view.poses.get(baseOf(view.chosen));
  if (get("follow").checked && pose) view.center = {x: pose.x, y: pose.y};
  if (isDirty) view.draw();
  isDirty = false;
  requestAnimationFrame(draw);
}
draw();
get("view").focus();
