"use strict";

const element = (id) => document.getElementById(id);
const text = (id) => element(id).textContent;
const about = JSON.parse(text("about"));

// ------------------------------------------------------------------------------------------------ data

function bytesOf(id) {
  const packed = atob(text(id).trim());
  const bytes = new Uint8Array(packed.length);
  for (let i = 0; i < packed.length; i++) bytes[i] = packed.charCodeAt(i);
  return bytes;
}

// Size and levels of a KTX2 file without supercompression.
function ktx2(bytes) {
  const view = new DataView(bytes.buffer);
  const word = (at) => view.getUint32(at, true);
  const count = word(40);
  const levels = [];
  for (let i = 0; i < count; i++) levels.push({ at: word(80 + 24 * i), length: word(88 + 24 * i) });
  return { width: word(20), height: word(24), layers: word(32), levels, buffer: bytes.buffer };
}

// ------------------------------------------------------------------------------------------------ device

const surface = document.createElement("canvas");
const gl = surface.getContext("webgl2", { antialias: Boolean(about.mesh), alpha: true, premultipliedAlpha: true });
const uniforms = {};

function compiled(kind, source) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
    throw new Error(`This browser refuses the shader. ${gl.getShaderInfoLog(shader)}`);
  }
  return shader;
}

function makeProgram() {
  const program = gl.createProgram();
  gl.attachShader(program, compiled(gl.VERTEX_SHADER, text("vertex")));
  gl.attachShader(program, compiled(gl.FRAGMENT_SHADER, text("material") + text("colour") + text("scene")));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`This browser refuses the shader. ${gl.getProgramInfoLog(program)}`);
  }
  gl.useProgram(program);
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
    const { name } = gl.getActiveUniform(program, i);
    uniforms[name] = gl.getUniformLocation(program, name);
  }
}

function parameters(target, filters) {
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, filters[0]);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, filters[1]);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
}

function bindTable() {
  const file = ktx2(bytesOf("texels"));
  if (file.width > gl.getParameter(gl.MAX_TEXTURE_SIZE) || file.layers > gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS)) {
    throw new Error("The table is larger than this device's textures.");
  }
  gl.activeTexture(gl.TEXTURE0);
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, gl.createTexture());
  parameters(gl.TEXTURE_2D_ARRAY, [gl.LINEAR_MIPMAP_NEAREST, gl.LINEAR]);
  gl.texStorage3D(gl.TEXTURE_2D_ARRAY, file.levels.length, gl.RGBA16F, file.width, file.height, file.layers);
  file.levels.forEach(({ at, length }, level) => {
    const side = file.width >> level;
    const numbers = new Uint16Array(file.buffer, at, length / 2);
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, level, 0, 0, 0, side, side, file.layers, gl.RGBA, gl.HALF_FLOAT, numbers);
  });
  gl.uniform1i(uniforms.diffract_table, 0);
}

function bindNumbers(unit, uniform, width, height, numbers) {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  parameters(gl.TEXTURE_2D, [gl.NEAREST, gl.NEAREST]);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, width, height);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA, gl.FLOAT, numbers);
  gl.uniform1i(uniforms[uniform], unit);
}

function bindFunctions() {
  const { width, height, levels, buffer } = ktx2(bytesOf("functions"));
  bindNumbers(1, "diffract_functions", width, height, new Float32Array(buffer, levels[0].at, levels[0].length / 4));
}

// Indices are stored as differences from the one before: 0, -1, 1, -2, 2 ... as 0, 1, 2, 3, 4 ..., seven bits a byte from the lowest on.
function indicesOf(bytes, count) {
  const indices = new Uint32Array(count);
  for (let i = 0, at = 0, last = 0; i < count; i++) {
    let number = 0, shift = 0;
    do {
      number |= (bytes[at] & 127) << shift;
      shift += 7;
    } while (bytes[at++] > 127);
    last += (number >>> 1) ^ -(number & 1);
    indices[i] = last;
  }
  return indices;
}

function bindMesh() {
  gl.uniform1i(uniforms.shadow, 4);
  if (!about.mesh) return;
  const VERTEX = 16, SIDE = 2048;
  const bytes = bytesOf("triangles"), [vertices, triangles] = about.mesh;
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, bytes.subarray(0, VERTEX * vertices), gl.STATIC_DRAW);
  gl.vertexAttribPointer(0, 4, gl.UNSIGNED_SHORT, true, VERTEX, 0);
  gl.vertexAttribPointer(1, 4, gl.SHORT, true, VERTEX, 8);
  gl.enableVertexAttribArray(0);
  gl.enableVertexAttribArray(1);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indicesOf(bytes.subarray(VERTEX * vertices), 3 * triangles), gl.STATIC_DRAW);
  depthFromLight = { side: SIDE, texture: gl.createTexture(), frame: gl.createFramebuffer() };
  gl.activeTexture(gl.TEXTURE4);
  gl.bindTexture(gl.TEXTURE_2D, depthFromLight.texture);
  parameters(gl.TEXTURE_2D, [gl.LINEAR, gl.LINEAR]);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SIDE, SIDE);
  gl.bindFramebuffer(gl.FRAMEBUFFER, depthFromLight.frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depthFromLight.texture, 0);
  gl.drawBuffers([gl.NONE]);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
}

function drawTriangles(view) {
  gl.uniform1i(uniforms.view, view);
  gl.enable(gl.DEPTH_TEST);
  gl.drawElements(gl.TRIANGLES, 3 * about.mesh[1], gl.UNSIGNED_INT, 0);
  gl.disable(gl.DEPTH_TEST);
}

function drawShadow() {
  const { side, texture, frame } = depthFromLight;
  gl.activeTexture(gl.TEXTURE4);
  gl.bindTexture(gl.TEXTURE_2D, null);
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.viewport(0, 0, side, side);
  gl.clear(gl.DEPTH_BUFFER_BIT);
  drawTriangles(SHADOW);
  gl.bindTexture(gl.TEXTURE_2D, texture);
}

// Draws a view, whose uniforms are set, into `target`.
function drawInto(target, view, width, height) {
  const solid = view === SHAPE && state.shape === MESH;
  if (solid) drawShadow();
  gl.bindFramebuffer(gl.FRAMEBUFFER, target);
  gl.viewport(0, 0, width, height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.uniform1i(uniforms.view, solid ? BACKDROP : view);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  if (solid) drawTriangles(SHAPE);
}

// Draws a view into floats and returns them, or nothing where the browser cannot.
function floats(view, width, height) {
  if (!gl.getExtension("EXT_color_buffer_float")) return undefined;
  const target = gl.createTexture(), depth = gl.createRenderbuffer(), frame = gl.createFramebuffer();
  gl.activeTexture(gl.TEXTURE3);
  gl.bindTexture(gl.TEXTURE_2D, target);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, width, height);
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
  gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
  gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  let numbers;
  if (gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE) {
    drawInto(frame, view, width, height);
    numbers = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, numbers);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.deleteFramebuffer(frame);
  gl.deleteTexture(target);
  gl.deleteRenderbuffer(depth);
  return numbers;
}

// ------------------------------------------------------------------------------------------------ state

const SPHERE = 0, DISC = 1, PLATE = 2, MESH = 3;
const SHAPE = 0, HEMISPHERE = 1, LIST = 2, SHADOW = 3, BACKDROP = 4;
const FOCAL = 3.2;
const initial = () => ({
  ...(about.mesh ? { shape: MESH, pitch: 0.6, distance: 0.85 } : { shape: SPHERE, pitch: 0.36, distance: 1 }),
  yaw: -0.42,
  light: [0.28, 0.42],
  shadows: true,
});
let state = initial();
let automatic = [0, 0]; // exposures of the shape and of the hemisphere [stops]
let scale = 1;          // of the picture while something moves
let sweeping = false;
let depthFromLight;     // texture of the shadows

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

function setUniforms(view, width, height) {
  const { right, up, back } = axes();
  const styles = getComputedStyle(document.documentElement);
  gl.uniform1i(uniforms.shape, state.shape);
  gl.uniform2f(uniforms.size, width, height);
  gl.uniformMatrix3fv(uniforms.camera, false, [...right, ...up, ...back]);
  gl.uniform1f(uniforms.eye_distance, 4.75 * state.distance);
  gl.uniform1f(uniforms.focal, FOCAL);
  const toward = toLight(), aside = Math.hypot(toward[0], toward[2]);
  const across = [toward[2] / aside, 0, -toward[0] / aside];
  gl.uniform3fv(uniforms.to_light, toward);
  gl.uniformMatrix3fv(uniforms.light_axes, false, [...across, ...cross(toward, across), ...toward]);
  gl.uniform1i(uniforms.shadows, state.shadows);
  gl.uniform1f(uniforms.light_spread, (spread() * Math.PI / 180) ** 2);
  gl.uniform1f(uniforms.pigment, view === SHAPE ? setting("pigment") : 0);
  gl.uniform3fv(uniforms.upper, linear(styles.getPropertyValue("--stage-1")));
  gl.uniform3fv(uniforms.lower, linear(styles.getPropertyValue("--stage-2")));
  gl.uniform1i(uniforms.as_radiance, 0);
}

// Stops at which a high percentile of the luminance is nearly white.
function suitedExposure(view) {
  const side = 96, share = 0.985, white = 1.3;
  setUniforms(view, side, side);
  gl.uniform1i(uniforms.as_radiance, 1);
  const numbers = floats(view, side, side);
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
  automatic = [suitedExposure(SHAPE), suitedExposure(HEMISPHERE)];
}

function paint(canvas, view, factor) {
  const ratio = Math.min(devicePixelRatio || 1, 2) * factor;
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio)), height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (surface.width !== width || surface.height !== height) Object.assign(surface, { width, height });
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  setUniforms(view, width, height);
  gl.uniform1f(uniforms.exposure, 2 ** (automatic[view] + setting("exposure")));
  drawInto(null, view, width, height);
  const to = canvas.getContext("2d");
  to.clearRect(0, 0, width, height);
  to.drawImage(surface, 0, 0);
}

function placeMarks() {
  const [x, y, z] = toLight();
  const percent = (a) => `${50 + 50 * a / 1.12}%`;
  Object.assign(element("light").style, { left: percent(x), top: percent(-y) });
  element("light").setAttribute("aria-valuenow", Math.round(Math.acos(z) * 180 / Math.PI));
  const { back } = axes();
  element("eye").setAttribute("transform", `translate(${back[0]} ${-back[1]})`);
  element("eye").style.display = back[2] > 0 ? "" : "none";
  for (const button of document.querySelectorAll("[data-shape]")) {
    button.setAttribute("aria-pressed", String(Number(button.dataset.shape) === state.shape));
  }
  const signed = (x) => `${x > 0 ? "+" : ""}${x.toFixed(1)}`;
  document.querySelector("[for=exposure]").value = `${signed(setting("exposure"))} stops`;
  document.querySelector("[for=spread]").value = `${spread().toPrecision(2)}°`;
  document.querySelector("[for=pigment]").value = `${Math.round(100 * setting("pigment"))} %`;
}

let waiting = false, rest = 0;

// Draws before the next frame is shown; after a `moving` one again in full size, once nothing moves.
function draw(moving = false) {
  keepInRange();
  placeMarks();
  clearTimeout(rest);
  if (moving && scale < 1) rest = setTimeout(() => draw(), 180);
  if (waiting || gl.isContextLost()) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    const begin = performance.now();
    paint(element("shape"), SHAPE, moving ? scale : 1);
    paint(element("hemisphere"), HEMISPHERE, moving ? scale : 1);
    if (!moving) return;
    // Reading a pixel waits for the device.
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    const time = performance.now() - begin;
    scale = clamp(scale * Math.sqrt(28 / Math.max(time, 1)), 0.3, 1);
  });
}

// ------------------------------------------------------------------------------------------------ hands

const pointers = new Map();

function turn(x, y) {
  state.yaw -= x;
  state.pitch += y;
}

function watchShape() {
  const canvas = element("shape");
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY], step = [now[0] - before[0], now[1] - before[1]];
    if (pointers.size > 1) {
      const [, other] = [...pointers].find(([id]) => id !== event.pointerId);
      const gap = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]);
      state.distance *= gap(before) / Math.max(gap(now), 1);
    } else if (event.buttons & 2 || event.shiftKey) {
      const unit = 0.5 * Math.min(canvas.clientWidth, canvas.clientHeight);
      state.light = [state.light[0] + step[0] / unit, state.light[1] - step[1] / unit];
    } else {
      turn(step[0] * 0.008, step[1] * 0.008);
    }
    pointers.set(event.pointerId, now);
    draw(true);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (event) => {
      pointers.delete(event.pointerId);
      draw();
    });
  }
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    state.distance *= Math.exp(0.001 * clamp(event.deltaY, -200, 200));
    draw(true);
    clearTimeout(rest);
    rest = setTimeout(() => draw(), 180);
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [0.08, 0], ArrowRight: [-0.08, 0], ArrowUp: [0, -0.08], ArrowDown: [0, 0.08] }[event.key];
    const zoom = { "+": 0.9, "-": 1.1 }[event.key];
    if (!step && !zoom) return;
    event.preventDefault();
    if (step) turn(...step);
    else state.distance *= zoom;
    draw();
  });
}

function watchLight() {
  const dome = document.querySelector(".dome");
  const move = (event) => {
    const box = dome.getBoundingClientRect();
    state.light = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height].map((share, i) => (i ? -1 : 1) * 1.12 * (2 * share - 1));
    draw(true);
  };
  dome.addEventListener("pointerdown", (event) => {
    dome.setPointerCapture(event.pointerId);
    stopSweep();
    move(event);
  });
  dome.addEventListener("pointermove", (event) => dome.hasPointerCapture(event.pointerId) && move(event));
  dome.addEventListener("pointerup", () => draw());
  dome.addEventListener("pointercancel", () => draw());
  element("light").addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-0.03, 0], ArrowRight: [0.03, 0], ArrowUp: [0, 0.03], ArrowDown: [0, -0.03] }[event.key];
    if (!step) return;
    event.preventDefault();
    state.light = state.light.map((x, i) => x + step[i]);
    draw();
  });
}

function stopSweep() {
  sweeping = false;
  element("sweep").setAttribute("aria-pressed", "false");
}

function sweep() {
  if (sweeping) {
    stopSweep();
    draw();
    return;
  }
  sweeping = true;
  element("sweep").setAttribute("aria-pressed", "true");
  const radius = clamp(Math.hypot(...state.light), 0.25, 0.85), start = Math.atan2(state.light[1], state.light[0]), begin = performance.now();
  const step = (now) => {
    if (!sweeping) return;
    const angle = start + Math.max(now - begin, 0) / 2600;
    state.light = [radius * Math.cos(angle), radius * Math.sin(angle)];
    draw(true);
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

function watchControls() {
  for (const button of document.querySelectorAll("[data-shape]")) {
    button.addEventListener("click", () => {
      state.shape = Number(button.dataset.shape);
      keepInRange();
      expose();
      draw();
    });
  }
  for (const id of ["exposure", "spread", "pigment"]) {
    element(id).addEventListener("input", () => draw(true));
    element(id).addEventListener("change", () => draw());
  }
  element("sweep").addEventListener("click", sweep);
  element("reset").addEventListener("click", () => {
    stopSweep();
    state = { ...initial(), shape: state.shape };
    for (const id of ["exposure", "spread", "pigment"]) element(id).value = element(id).defaultValue;
    expose();
    draw();
  });
  element("save").addEventListener("click", () => {
    element("shape").toBlob((blob) => {
      const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: `${about.name}.png` });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  });
  element("copy").addEventListener("click", () => {
    const range = document.createRange();
    range.selectNodeContents(element("command"));
    getSelection().removeAllRanges();
    getSelection().addRange(range);
    document.execCommand("copy");
    element("copy").textContent = "Copied";
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw());
  addEventListener("resize", () => draw());
}

// ------------------------------------------------------------------------------------------------ words

function add(parent, tag, content) {
  const child = document.createElement(tag);
  child.textContent = content;
  element(parent).append(child);
  return child;
}

function tell() {
  element("lead").textContent = about.lead;
  for (const [name, value] of about.facts) {
    add("facts", "dt", name);
    add("facts", "dd", value);
  }
  for (const [name, value] of about.more) {
    add("more", "dt", name);
    add("more", "dd", value);
  }
  about.trust.forEach((line) => add("trust", "li", line));
  about.citations.forEach((line) => add("cite", "li", line));
  element("command").textContent = about.command;
  element("made").textContent = about.made;
  element("low").textContent = about.heights[0];
  element("high").textContent = about.heights[1];
  element("bar").textContent = about.bar.text;
  placeBar();
  addEventListener("resize", placeBar);
  element("relief").addEventListener("load", placeBar);
}

// The picture keeps its shape, so that it may be narrower than its box.
function placeBar() {
  const { clientWidth, clientHeight, naturalWidth, naturalHeight } = element("relief");
  const width = Math.min(clientWidth, clientHeight * naturalWidth / Math.max(naturalHeight, 1));
  element("bar").style.width = `${about.bar.share * width}px`;
}

// ------------------------------------------------------------------------------------------------ check

// Evaluates listed directions here and returns ‖here − table‖/‖table‖, or nothing where the browser cannot draw floats.
function deviation() {
  const bytes = bytesOf("directions");
  const rows = new Float32Array(bytes.buffer);
  const columns = 13, count = rows.length / columns;
  const list = new Float32Array(12 * count);
  for (let i = 0; i < count; i++) {
    const row = rows.subarray(columns * i, columns * (i + 1));
    list.set(row.subarray(0, 3), 4 * i);
    list.set(row.subarray(3, 6), 4 * (count + i));
    list.set(row.subarray(6, 10), 4 * (2 * count + i));
  }
  bindNumbers(2, "list", count, 3, list);
  setUniforms(LIST, count, 1);
  const found = floats(LIST, count, 1);
  if (!found) return undefined;
  let off = 0, all = 0;
  for (let i = 0; i < count; i++) {
    for (let c = 0; c < 3; c++) {
      const expected = rows[columns * i + 10 + c];
      off += (found[4 * i + c] - expected) ** 2;
      all += expected ** 2;
    }
  }
  return Math.sqrt(off / all);
}

function check() {
  const off = deviation();
  const line = off === undefined
    ? "This browser cannot draw floats, so that its colours were not compared with the table."
    : `Drawn by this browser, ${about.directions} directions differ from the 64-bit reading of the table by ${(100 * off).toPrecision(2)} %.`;
  add("trust", "li", line);
  document.documentElement.dataset.deviation = off ?? "";
}

// Linear radiance of the shape under a point of light, for tests: rows from the bottom, red, green, blue and cover.
function radiance(width, height) {
  setUniforms(SHAPE, width, height);
  gl.uniform1f(uniforms.light_spread, 0);
  gl.uniform1i(uniforms.as_radiance, 1);
  return floats(SHAPE, width, height);
}

function begin() {
  tell();
  if (!gl) throw new Error("This page draws with WebGL 2, which this browser does not offer.");
  makeProgram();
  bindTable();
  bindFunctions();
  bindMesh();
  element("meshes").hidden = !about.mesh;
  check();
  expose();
  watchShape();
  watchLight();
  watchControls();
  draw();
  surface.addEventListener("webglcontextlost", () => fail(new Error("The graphics device was reset. Load this page again.")));
}

function fail(error) {
  element("failure").hidden = false;
  element("failure").textContent = error.message;
}

try {
  begin();
} catch (error) {
  fail(error);
}
