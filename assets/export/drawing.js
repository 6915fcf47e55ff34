
// ------------------------------------------------------------------------------------------------ state

const SPHERE = 0, DISC = 1, PLATE = 2, MESH = 3;
const SHAPE = 0, HEMISPHERE = 1, LIST = 2, SHADOW = 3, BACKDROP = 4;
const FOCAL = 3.2;
// The still picture in src/export/page_still.rs has the same view of the sphere.
const initial = () => ({
  ...(about.mesh ? { shape: MESH, pitch: 0.6, distance: 0.85 } : { shape: SPHERE, pitch: 0.36, distance: 1 }),
  yaw: -0.42,
  light: [0.28, 0.42],
  shadows: true,
});
let state = initial();
let automatic = [0, 0]; // exposures of the shape and of the hemisphere [stops]
let scale = 0.2;        // of the first picture of a view, small where the device is slow
let sweeping = false;
let ready = false;      // true once the device can draw

// From an address such as page.html#plate,yaw=0.2,pitch=0.1,x=0.3,y=0.4
for (const part of decodeURIComponent(location.hash.slice(1)).split(",")) {
  const [name, value] = part.split("=");
  const shapes = ["sphere", "disc", "plate", ...(about.mesh ? ["mesh"] : [])];
  if (shapes.includes(name)) state.shape = shapes.indexOf(name);
  else if (["yaw", "pitch", "distance"].includes(name) && isFinite(value)) state[name] = Number(value);
  else if (["x", "y"].includes(name) && isFinite(value)) state.light[name === "y" ? 1 : 0] = Number(value);
}

const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

function keepInRange() {
  const round = state.shape === SPHERE || state.shape === MESH, most = round ? 1.5 : 1.25;
  state.pitch = clamp(state.pitch, -most, most);
  if (!round) state.yaw = clamp(state.yaw, -most, most);
  state.distance = clamp(state.distance, 0.32, 2);
  const size = Math.hypot(...state.light);
  if (size > 0.995) state.light = state.light.map((x) => x * 0.995 / size);
}

const toLight = () => [...state.light, Math.sqrt(1 - state.light[0] ** 2 - state.light[1] ** 2)];

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

function axes() {
  const { yaw, pitch } = state;
  const back = [Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch)];
  const right = [Math.cos(yaw), 0, -Math.sin(yaw)];
  return { right, up: cross(back, right), back };
}

const setting = (id) => Number(element(id).value);
const spread = () => 10 ** setting("spread"); // standard deviation [degrees]

// ------------------------------------------------------------------------------------------------ drawing

function linear(color) {
  const [r, g, b] = color.match(/[\da-f]{2}/gi).map((pair) => parseInt(pair, 16) / 255);
  return [r, g, b].map((x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4));
}

// Sets the uniforms of a view and returns those that depths need, too.
function setUniforms(view, width, height) {
  const { right, up, back } = axes();
  const styles = getComputedStyle(document.documentElement);
  const toward = toLight(), aside = Math.hypot(toward[0], toward[2]);
  const across = [toward[2] / aside, 0, -toward[0] / aside];
  const values = {
    size: [width, height],
    camera: [...right, ...up, ...back],
    eye_distance: 4.75 * state.distance,
    light_axes: [...across, ...cross(toward, across), ...toward],
  };
  gl.uniform1i(uniforms.shape, state.shape);
  gl.uniform2f(uniforms.size, width, height);
  gl.uniformMatrix3fv(uniforms.camera, false, values.camera);
  gl.uniform1f(uniforms.eye_distance, values.eye_distance);
  gl.uniform1f(uniforms.focal, FOCAL);
  gl.uniform3fv(uniforms.to_light, toward);
  gl.uniformMatrix3fv(uniforms.light_axes, false, values.light_axes);
  gl.uniform1i(uniforms.shadows, state.shadows);
  gl.uniform1f(uniforms.light_spread, (spread() * Math.PI / 180) ** 2);
  gl.uniform1f(uniforms.pigment, view === SHAPE ? setting("pigment") : 0);
  gl.uniform1i(uniforms.parts, view === SHAPE && element("around").checked ? about.surroundings[0] : 0);
  gl.uniform1f(uniforms.brightness, 2 ** setting("brightness"));
  gl.uniform3fv(uniforms.upper, linear(styles.getPropertyValue("--stage-1")));
  gl.uniform3fv(uniforms.lower, linear(styles.getPropertyValue("--stage-2")));
  gl.uniform1i(uniforms.as_radiance, 0);
  return values;
}

// Stops at which a high percentile of the luminance is nearly white.
function suitedExposure(view) {
  const side = 64, share = 0.985, white = 1.3;
  const values = setUniforms(view, side, side);
  gl.uniform1i(uniforms.as_radiance, 1);
  const numbers = floats(view, values);
  if (!numbers) return 0;
  const bright = [];
  for (let i = 0; i < numbers.length; i += 4) {
    if (numbers[i + 3] > 0.5) bright.push(0.2126 * numbers[i] + 0.7152 * numbers[i + 1] + 0.0722 * numbers[i + 2]);
  }
  bright.sort((a, b) => a - b);
  const high = bright[Math.floor(share * (bright.length - 1))];
  return high > 0 ? clamp(Math.log2(white / high), -20, 20) : 0;
}

function expose() {
  if (ready) automatic = [suitedExposure(SHAPE), suitedExposure(HEMISPHERE)];
}

// Gives a canvas, and the surface that is drawn on, as many pixels as the screen has there.
function fit(canvas) {
  const ratio = Math.min(devicePixelRatio || 1, 2);
  const size = [canvas.clientWidth, canvas.clientHeight].map((length) => Math.max(1, Math.round(length * ratio)));
  if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
  if (surface.width < size[0]) surface.width = size[0];
  if (surface.height < size[1]) surface.height = size[1];
  return size;
}

// Draws a view at a part of its size, `factor`, and stretches it; or some of its rows, from the bottom.
function paint(canvas, view, factor, rows) {
  const [width, height] = fit(canvas), drawn = [width, height].map((length) => Math.max(1, Math.round(length * factor)));
  const values = setUniforms(view, ...drawn);
  gl.uniform1f(uniforms.exposure, 2 ** (automatic[view] + setting("exposure")));
  if (factor === 1 && view === SHAPE && state.shape === MESH) drawSmoothly(view, values, rows);
  else drawInto(null, view, values, rows);
  const [first, count] = rows || [0, drawn[1]], stretch = height / drawn[1];
  const top = (drawn[1] - first - count) * stretch, to = canvas.getContext("2d");
  // Stretched, the outer half of each pixel at the edge is left out, because it is mixed with what lies beside the picture.
  const inset = factor < 1 ? 0.5 : 0;
  to.imageSmoothingQuality = "high";
  to.clearRect(0, top, width, count * stretch);
  to.drawImage(surface, inset, surface.height - first - count + inset, drawn[0] - 2 * inset, count - 2 * inset, 0, top, width, count * stretch);
}

// Waits for the device by reading a pixel; returns the time that drawing took [ms].
function timed(drawing) {
  const begin = performance.now();
  drawing();
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  return performance.now() - begin;
}

const VIEWS = [["shape", SHAPE], ["hemisphere", HEMISPHERE]];
const note = (word) => { document.documentElement.dataset.state = word; };
let waiting = false, asked = 0, rest = 0;

// Draws before the next frame is shown: small where the device is slow, and once nothing changes in full size, strip by strip.
function draw(moving = false) {
  keepInRange();
  placeMarks();
  asked += 1;
  clearTimeout(rest);
  if (!ready || gl.isContextLost()) return;
  note("small");
  if (!waiting) requestAnimationFrame(() => drawSmall(moving));
  waiting = true;
}

function drawSmall(moving) {
  waiting = false;
  const part = scale;
  const time = timed(() => VIEWS.forEach(([id, view]) => paint(element(id), view, part)));
  element("still").hidden = true;
  // The time of all pixels. A single one may be much slower than those after it, because it waits for the device.
  const whole = time / part ** 2, mark = asked;
  scale = clamp(Math.sqrt(28 / Math.max(whole, 1)), 0.15, 1);
  if (part === 1) note("drawn");
  else rest = setTimeout(() => refine(mark, clamp(Math.ceil(whole / 120), 1, 48)), moving || sweeping ? 180 : 0);
}

// Draws all in full size in `strips`, and stops once something else is asked for.
async function refine(mark, strips) {
  for (const [id, view] of VIEWS) {
    const canvas = element(id), height = fit(canvas)[1], count = view === SHAPE ? strips : Math.ceil(strips / 6);
    for (let i = count; i > 0; i--) {
      const [first, end] = [i - 1, i].map((share) => Math.round(height * share / count));
      if (mark !== asked || gl.isContextLost()) return;
      timed(() => paint(canvas, view, 1, [first, end - first]));
      await pause(0);
    }
  }
  if (mark === asked) note("drawn");
}

// ------------------------------------------------------------------------------------------------ marks

function placeMarks() {
  const [x, y, z] = toLight();
  const percent = (a) => `${50 + 50 * a / 1.12}%`, degrees = (angle) => Math.round(angle * 180 / Math.PI);
  const light = element("light"), tilt = degrees(Math.acos(z)), azimuth = (degrees(Math.atan2(y, x)) + 360) % 360;
  Object.assign(light.style, { left: percent(x), top: percent(-y) });
  light.setAttribute("aria-valuenow", tilt);
  light.setAttribute("aria-valuetext", `${tilt} degrees from the normal, azimuth ${azimuth} degrees`);
  const { back } = axes();
  element("eye").setAttribute("transform", `translate(${back[0]} ${-back[1]})`);
  element("eye").style.display = back[2] > 0 ? "" : "none";
  for (const button of document.querySelectorAll("[data-shape]")) {
    button.setAttribute("aria-pressed", String(Number(button.dataset.shape) === state.shape));
  }
  element("brightness").disabled = !element("around").checked;
  const signed = (id) => `${setting(id) > 0 ? "+" : ""}${setting(id).toFixed(1)} stops`;
  const words = {
    exposure: signed("exposure"),
    spread: `${spread().toPrecision(2)}°`,
    pigment: `${Math.round(100 * setting("pigment"))} %`,
    brightness: element("around").checked ? signed("brightness") : "off",
  };
  for (const [id, value] of Object.entries(words)) {
    element(`${id}-value`).value = value;
    element(id).setAttribute("aria-valuetext", value);
  }
}
