// Draws the world: walls, models, scans, trails and names. Lengths are in metres, y points up.

const LOOKS = {
  light: {ground: "#f4f5f7", area: "rgba(31, 111, 235, 0.10)", hit: "#d92d20", chosen: "#1f6feb", name: "#1d2330"},
  dark: {ground: "#14171d", area: "rgba(96, 160, 255, 0.13)", hit: "#ff5a4d", chosen: "#5b9bff", name: "#dfe3ea"},
};
const TRAILS = ["#2f7de1", "#f08c00"];  // the true way, and the odometry's
const LEAST_CONTRAST = 0.4;
const FOLLOWED_WIDTH = 12;  // m

const css = ({r, g, b, a}) => `rgba(${r * 255 | 0}, ${g * 255 | 0}, ${b * 255 | 0}, ${a})`;

/** The colour of lines that can be seen on the ground: a colour that is too near to it is inverted. */
function visible({r, g, b, a}, isDark) {
  const isNear = Math.abs((r + g + b) / 3 - (isDark ? 0.08 : 0.96)) < LEAST_CONTRAST;
  return css(isNear ? {r: 1 - r, g: 1 - g, b: 1 - b, a} : {r, g, b, a});
}

export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.center = {x: 0, y: 0};
    this.scale = 20;  // pixels per metre
    this.bounds = null;  // of the walls, all of which are shown until the view is moved
    this.isMoved = false;
    this.layers = [];  // {path, color}
    this.shapes = new Map();  // by body, "model/body": {fill, outline, color}
    this.poses = new Map();  // of bodies, as the keys of shapes
    this.scans = new Map();  // by topic: {pose, message}
    this.models = [];  // {name, body, radius, isRobot}
    this.trails = [];  // lists of {x, y}
    this.chosen = null;  // the name of a model
    this.showsNames = true;  // of robots
    this.isDark = false;
    this.arrow = null;  // {from, to}: a model that is about to be spawned
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  resize() {
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = this.canvas.clientWidth * ratio;
    this.canvas.height = this.canvas.clientHeight * ratio;
    this.ratio = ratio;
    this.fit();
    this.draw();
  }

  /** walls: flatland_msgs/Walls. */
  setWalls(walls) {
    let [minX, minY, maxX, maxY] = [Infinity, Infinity, -Infinity, -Infinity];
    this.layers = walls.layers.map(({segments: s, color}) => {
      const path = new Path2D();
      for (let i = 0; i + 3 < s.length; i += 4) {
        path.moveTo(s[i], s[i + 1]);
        path.lineTo(s[i + 2], s[i + 3]);
        minX = Math.min(minX, s[i], s[i + 2]); maxX = Math.max(maxX, s[i], s[i + 2]);
        minY = Math.min(minY, s[i + 1], s[i + 3]); maxY = Math.max(maxY, s[i + 1], s[i + 3]);
      }
      return {path, color};
    });
    this.bounds = minX <= maxX ? [minX, minY, maxX, maxY] : null;
    this.fit();
  }

  fit() {
    if (!this.bounds || this.isMoved) return;
    const [minX, minY, maxX, maxY] = this.bounds;
    const {clientWidth: width, clientHeight: height} = this.canvas;
    this.center = {x: (minX + maxX) / 2, y: (minY + maxY) / 2};
    this.scale = 0.95 * Math.min(width / Math.max(maxX - minX, 1), height / Math.max(maxY - minY, 1));
  }

  /** markers: of visualization_msgs/MarkerArray; the shapes of bodies in their own frames. */
  setShapes(markers) {
    for (const marker of markers) {
      if (marker.action === 3) { this.shapes.clear(); continue; }
      const shape = this.shapes.get(marker.ns) ?? {};
      const path = new Path2D(), isFill = marker.type === 11, points = marker.points;
      for (let i = 0; i < points.length; i += isFill ? 3 : 2) {
        path.moveTo(points[i].x, points[i].y);
        path.lineTo(points[i + 1].x, points[i + 1].y);
        if (isFill) path.lineTo(points[i + 2].x, points[i + 2].y);
      }
      shape[isFill ? "fill" : "outline"] = path;
      shape[isFill ? "fillColor" : "color"] = marker.color;
      this.shapes.set(marker.ns, shape);
    }
  }

  /** Shows the whole world. */
  showAll() {
    this.isMoved = false;
    this.fit();
  }

  /** Comes so near that a model can be seen well. */
  comeNear() {
    this.isMoved = true;
    this.scale = Math.max(this.scale, this.canvas.clientWidth / FOLLOWED_WIDTH);
  }

  toWorld(event) {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    return {
      x: this.center.x + (event.offsetX - width / 2) / this.scale,
      y: this.center.y - (event.offsetY - height / 2) / this.scale,
    };
  }

  zoom(event, factor) {
    const before = this.toWorld(event);
    this.scale = Math.min(2000, Math.max(0.5, this.scale * factor));
    const after = this.toWorld(event);
    this.center.x += before.x - after.x;
    this.center.y += before.y - after.y;
    this.isMoved = true;
  }

  draw() {
    const {context: c, canvas, ratio = 1} = this, scale = this.scale * ratio;
    const look = this.look = LOOKS[this.isDark ? "dark" : "light"];
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.fillStyle = look.ground;
    c.fillRect(0, 0, canvas.width, canvas.height);
    c.setTransform(scale, 0, 0, -scale,
      canvas.width / 2 - this.center.x * scale, canvas.height / 2 + this.center.y * scale);
    const pixel = ratio / scale;
    const beams = [...this.scans.values()].map((scan) => this.drawArea(scan));
    c.lineWidth = Math.max(0.05, 1.5 * pixel);
    for (const {path, color} of this.layers) {
      c.strokeStyle = visible(color, this.isDark);
      c.stroke(path);
    }
    this.trails.forEach((trail, i) => this.drawTrail(trail, TRAILS[i], i * 6 * pixel, pixel));
    c.fillStyle = look.hit;
    for (const [x, y, isReturn] of beams.flat()) {
      if (isReturn) c.fillRect(x - 1.5 * pixel, y - 1.5 * pixel, 3 * pixel, 3 * pixel);
    }
    for (const [body, shape] of this.shapes) {
      const pose = this.poses.get(body);
      if (pose) this.drawShape(shape, pose, pixel, body.startsWith(`${this.chosen}/`));
    }
    for (const model of this.models) this.drawName(model, pixel);
    if (this.arrow) {
      c.strokeStyle = look.chosen;
      c.lineWidth = 2 * pixel;
      c.beginPath();
      c.arc(this.arrow.from.x, this.arrow.from.y, 6 * pixel, 0, 2 * Math.PI);
      c.moveTo(this.arrow.from.x, this.arrow.from.y);
      c.lineTo(this.arrow.to.x, this.arrow.to.y);
      c.stroke();
    }
  }

  drawShape(shape, pose, pixel, isChosen) {
    const c = this.context;
    c.save();
    c.translate(pose.x, pose.y);
    c.rotate(pose.theta);
    c.fillStyle = shape.fill ? css(shape.fillColor) : "";
    if (shape.fill) c.fill(shape.fill);
    c.strokeStyle = isChosen ? this.look.chosen : shape.outline ? visible(shape.color, this.isDark) : "";
    c.lineWidth = (isChosen ? 2.5 : 1) * pixel;
    if (shape.outline) c.stroke(shape.outline);
    c.restore();
  }

  drawTrail(trail, color, dash, pixel) {
    const c = this.context;
    c.setLineDash(dash ? [dash, dash] : []);
    c.strokeStyle = color;
    c.lineWidth = 2 * pixel;
    c.beginPath();
    for (const {x, y} of trail) c.lineTo(x, y);
    c.stroke();
    c.setLineDash([]);
  }

  /** Writes a robot's name beside it; the chosen model has a ring and always its name. */
  drawName({name, body, radius, isRobot}, pixel) {
    const pose = this.poses.get(body), c = this.context, isChosen = name === this.chosen;
    if (!pose || !(isChosen || isRobot && this.showsNames)) return;
    const reach = radius + 6 * pixel;
    c.save();
    c.translate(pose.x, pose.y);
    c.strokeStyle = this.look.chosen;
    c.lineWidth = 2 * pixel;
    c.beginPath();
    c.arc(0, 0, reach, 0, 2 * Math.PI);
    if (isChosen) c.stroke();
    c.scale(pixel, -pixel);
    c.font = `${isChosen ? "bold " : ""}13px system-ui, sans-serif`;
    c.strokeStyle = this.look.ground;  // behind the letters, on walls
    c.lineWidth = 3;
    c.fillStyle = isChosen ? this.look.chosen : this.look.name;
    const x = reach / pixel + 4;
    c.strokeText(name, x, 4);
    c.fillText(name, x, 4);
    c.restore();
  }

  /** Fills what a scan has seen, and returns the ends of its beams: x, y, and whether it hit. */
  drawArea({pose, message}) {
    const c = this.context;
    const {angle_min: begin, angle_increment: increment, range_max: max, ranges} = message;
    const ends = ranges.map((range, i) => {
      const isReturn = range !== null && range <= max;
      const angle = pose.theta + begin + i * increment, reach = isReturn ? range : max;
      return [pose.x + reach * Math.cos(angle), pose.y + reach * Math.sin(angle), isReturn];
    });
    c.fillStyle = this.look.area;
    c.beginPath();
    c.moveTo(pose.x, pose.y);
    for (const [x, y] of ends) c.lineTo(x, y);
    c.fill();
    return ends;
  }
}
