// A walker in the plane, as pages draw it. Put before a page's own script, within one function.
const byId = (id) => document.getElementById(id);
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));
const number = (x) => String(+x.toFixed(2)).replace("-", "−");
const signed = (x) => (x > 0 ? "+" : "") + number(x);
const colours = {};

/** Read the theme's colours, now and whenever it changes, and draw anew. */
function themed(redraw) {
  const read = () => {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["ink", "soft", "line", "sky-top", "sky", "ground", "ground-line", "grid", "near", "far", "trunk", "head", "joint", "push", "speed", "ghost", "accent", "back", "panel"])
      colours[name] = style.getPropertyValue(`--${name}`).trim();
    redraw();
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", read);
  read();
}

/** The world's (x, z) of a point of a placed body. */
function beside(body, x, z) {
  const c = Math.cos(body.turn), s = Math.sin(body.turn);
  return { x: body.x + c * x + s * z, z: body.z - s * x + c * z };
}

/** Place (m) and turn from the upright (rad) of every body, of a pose: x, z, pitch, then each joint's angle. */
function bodies(figure, pose) {
  const found = [];
  figure.bodies.forEach((body, i) => {
    if (body.parent < 0) { found.push({ x: pose[0], z: pose[1], turn: pose[2] }); return; }
    const on = found[body.parent], joint = beside(on, body.x, body.z);
    found.push({ ...joint, turn: on.turn + body.turn * pose[i + 2] });
  });
  return found;
}

/** The canvas, its pixels those of the screen, cleared; sizes in CSS pixels. */
function prepare(canvas) {
  const ratio = window.devicePixelRatio || 1, wide = canvas.clientWidth, high = canvas.clientHeight;
  if (canvas.width !== Math.round(wide * ratio)) canvas.width = Math.round(wide * ratio);
  if (canvas.height !== Math.round(high * ratio)) canvas.height = Math.round(high * ratio);
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, wide, high);
  pen.lineCap = pen.lineJoin = "round";
  return [pen, wide, high];
}

function font(pen, size, bold) {
  pen.font = `${bold ? "600 " : ""}${size}px system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif`;
}

/** A part of a canvas, `wide` and `high` from `top`, that looks at the world around x = `middle`, m. */
function view(pen, wide, high, top, middle, stature) {
  const scale = high * 0.86 / (1.12 * stature), ground = top + high * 0.86, left = middle - wide / scale / 2;
  return { pen, wide, high, top, scale, ground, left, sx: (x) => (x - left) * scale, sz: (z) => ground - z * scale };
}

/** Sky, floor, and a mark each half metre. */
function drawWorld({ pen, wide, high, top, scale, ground, left, sx }) {
  const sky = pen.createLinearGradient(0, top, 0, ground);
  sky.addColorStop(0, colours["sky-top"]); sky.addColorStop(1, colours.sky);
  pen.fillStyle = sky; pen.fillRect(0, top, wide, ground - top);
  pen.fillStyle = colours.ground; pen.fillRect(0, ground, wide, top + high - ground);
  font(pen, 12);
  for (let half = Math.ceil(left * 2); half <= (left + wide / scale) * 2; half++) {
    const x = sx(half / 2), whole = half % 2 === 0;
    pen.fillStyle = colours.grid;
    if (whole) pen.fillRect(x - 0.5, top, 1, ground - top);
    pen.fillStyle = colours["ground-line"];
    pen.fillRect(x - 0.5, ground, 1, whole ? 9 : 5);
    if (whole && (half % 4 === 0 || scale > 60)) { pen.fillStyle = colours.soft; pen.textAlign = "center"; pen.textBaseline = "bottom"; pen.fillText(`${number(half / 2)} m`, x, top + high - 5); }
  }
  pen.fillStyle = colours["ground-line"]; pen.fillRect(0, ground - 0.75, wide, 1.5);
}

/** Where a foot came down. */
function drawPrint({ pen, ground, sx }, x, leg) {
  pen.fillStyle = colours[leg ? "near" : "far"];
  pen.beginPath(); pen.moveTo(sx(x), ground + 2); pen.lineTo(sx(x) - 5, ground + 10); pen.lineTo(sx(x) + 5, ground + 10); pen.fill();
}

/** All shapes of a figure whose bodies are placed; `size`: of lengths against the figure's. */
function drawFigure({ pen, scale, sx, sz }, figure, placed, stature, size = 1) {
  for (const shape of figure.shapes) {
    const body = placed[shape.body];
    pen.save();
    pen.translate(sx(body.x), sz(body.z)); pen.rotate(body.turn); pen.scale(scale * size, -scale * size);
    const halo = 2.5 / scale / size, path = new Path2D();
    pen.fillStyle = pen.strokeStyle = colours[shape.colour];
    if (shape.kind === "block") {
      const { x, z, half_x: a, half_z: b } = shape;
      path.roundRect(x - a, z - b, 2 * a, 2 * b, Math.min(a, b) * 0.95);
      outlined(pen, path, 0, halo, true);
    } else if (shape.kind === "limb") {
      path.moveTo(shape.x, shape.z + shape.half_z); path.lineTo(shape.x, shape.z - shape.half_z);
      outlined(pen, path, 2 * shape.half_x, halo, false);
    } else {
      shape.points.forEach(([x, z], i) => (i ? path.lineTo(x, z) : path.moveTo(x, z)));
      path.closePath();
      outlined(pen, path, 2 * shape.radius, halo, true);
    }
    if (shape.kind !== "block") {  // the joint it hangs by
      pen.fillStyle = colours.joint; pen.globalAlpha = 0.75;
      pen.beginPath(); pen.arc(0, 0, stature * 0.009, 0, 2 * Math.PI); pen.fill();
    }
    pen.restore();
  }
}

/** A shape with a thin rim of the sky's colour, so that legs which cross stay apart. */
function outlined(pen, path, width, halo, filled) {
  const colour = pen.fillStyle;
  pen.strokeStyle = colours.sky; pen.lineWidth = width + 2 * halo; pen.stroke(path);
  pen.strokeStyle = colour; pen.lineWidth = Math.max(width, 1e-4); pen.stroke(path);
  if (filled) pen.fill(path);
}

/** A push's arrow, `long` pixels, with its tip at (tip, y); forward pushes come from the left. */
function drawArrow(pen, tip, y, long, impulse, strength = 1) {
  const away = -Math.sign(impulse), back = away * long, nib = away * Math.min(15, long / 2);
  pen.save();
  pen.fillStyle = pen.strokeStyle = colours.push;
  pen.globalAlpha = strength; pen.lineWidth = 6; pen.lineCap = "butt";
  pen.beginPath(); pen.moveTo(tip + back, y); pen.lineTo(tip + nib, y); pen.stroke();
  pen.beginPath(); pen.moveTo(tip, y); pen.lineTo(tip + nib, y - 9); pen.lineTo(tip + nib, y + 9); pen.fill();
  font(pen, 15, true); pen.textBaseline = "bottom"; pen.textAlign = away < 0 ? "right" : "left";
  pen.fillText(`push ${signed(impulse)} N s`, tip + nib, y - 12);
  pen.restore();
}
