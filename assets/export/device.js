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

// ------------------------------------------------------------------------------------------------ programs

const DEPTH_ALONE = "#version 300 es\nvoid main() {}\n";
const surface = document.createElement("canvas");
let gl, parallel;       // context of the surface, and its extension that tells whether a program is compiled
let scene, depths;      // programs: of pictures, and of depths alone
let uniforms = {};      // places of the uniforms of `scene`
let depthFromLight;     // texture of the shadows, and the light that it is of
let shadowPasses = 0;   // times that it was drawn
let fourfold;           // framebuffer of four samples a pixel for the edges of the mesh, as large as the surface

const pause = (time) => new Promise((done) => setTimeout(done, time));

function openDevice() {
  gl = surface.getContext("webgl2", { antialias: false, alpha: true, premultipliedAlpha: true });
  if (!gl) throw new Error("This browser does not offer WebGL 2, with which the page draws. This is a still picture, drawn when the page was written.");
  surface.addEventListener("webglcontextlost", () => fail(new Error("The graphics device was reset. Load this page again.")));
  parallel = gl.getExtension("KHR_parallel_shader_compile");
  // All is drawn in the same state, for which some devices compile a program anew.
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL);
  gl.enable(gl.SCISSOR_TEST);
}

function startShader(program, kind, source) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  gl.attachShader(program, shader);
  return shader;
}

function startProgram(fragment) {
  const program = gl.createProgram();
  const shaders = [startShader(program, gl.VERTEX_SHADER, text("vertex")), startShader(program, gl.FRAGMENT_SHADER, fragment)];
  gl.linkProgram(program);
  return { program, shaders, uniforms: {} };
}

// Waits for a program; the page goes on meanwhile, where the browser can tell when it is done.
async function finishProgram({ program, shaders, uniforms }) {
  while (parallel && !gl.isContextLost() && !gl.getProgramParameter(program, parallel.COMPLETION_STATUS_KHR)) await pause(20);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    const log = [...shaders.map((shader) => gl.getShaderInfoLog(shader)), gl.getProgramInfoLog(program)].find(Boolean);
    throw new Error(`This browser refuses the shader. ${log}`);
  }
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
    const name = gl.getActiveUniform(program, i).name.replace("[0]", "");
    uniforms[name] = gl.getUniformLocation(program, name);
  }
}

// ------------------------------------------------------------------------------------------------ textures

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
}

function bindNumbers(unit, width, height, numbers) {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  parameters(gl.TEXTURE_2D, [gl.NEAREST, gl.NEAREST]);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, width, height);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA, gl.FLOAT, numbers);
}

function bindFunctions() {
  const { width, height, levels, buffer } = ktx2(bytesOf("functions"));
  bindNumbers(1, width, height, new Float32Array(buffer, levels[0].at, levels[0].length / 4));
}

// Reads the parts of the surroundings and the levels of their picture, whose rows continue at their other ends.
function bindSurroundings() {
  const [count, width] = about.surroundings, { buffer } = bytesOf("surroundings");
  const numbers = new Float32Array(buffer, 0, 8 * count), toward = [], light = [];
  for (let i = 0; i < count; i++) {
    toward.push(...numbers.subarray(8 * i, 8 * i + 4));
    light.push(...numbers.subarray(8 * i + 4, 8 * i + 8));
  }
  gl.uniform4fv(uniforms.part_toward, toward);
  gl.uniform4fv(uniforms.part_light, light);
  gl.activeTexture(gl.TEXTURE5);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  parameters(gl.TEXTURE_2D, [gl.LINEAR_MIPMAP_LINEAR, gl.LINEAR]);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
  gl.texStorage2D(gl.TEXTURE_2D, Math.log2(width) + 1, gl.RGB16F, width, width / 2);
  for (let level = 0, at = 32 * count; width >> level > 0; level++) {
    const size = [width >> level, Math.max(width >> (level + 1), 1)], texels = 3 * size[0] * size[1];
    gl.texSubImage2D(gl.TEXTURE_2D, level, 0, 0, ...size, gl.RGB, gl.HALF_FLOAT, new Uint16Array(buffer, at, texels));
    at += 2 * texels;
  }
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
}

function bindMesh() {
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
  depthFromLight = { side: SIDE, texture: gl.createTexture(), frame: gl.createFramebuffer(), light: "" };
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

// Gives the scene its textures, and calls `wait` between them.
async function bindAll(wait) {
  gl.useProgram(scene.program);
  const units = { diffract_table: 0, diffract_functions: 1, list: 2, shadow: 4, surroundings: 5 };
  for (const [name, unit] of Object.entries(units)) gl.uniform1i(uniforms[name], unit);
  for (const bind of [bindTable, bindFunctions, bindSurroundings, bindMesh]) {
    bind();
    await wait();
  }
}

// ------------------------------------------------------------------------------------------------ pictures

// Draws depths alone, as `view` sees the mesh. The uniforms are those that the scene was given last.
function drawDepths(view, values) {
  gl.useProgram(depths.program);
  const { size, camera, eye_distance, light_axes } = values;
  gl.uniform1i(depths.uniforms.view, view);
  gl.uniform1i(depths.uniforms.shape, MESH);
  gl.uniform2f(depths.uniforms.size, ...size);
  gl.uniformMatrix3fv(depths.uniforms.camera, false, camera);
  gl.uniform1f(depths.uniforms.eye_distance, eye_distance);
  gl.uniform1f(depths.uniforms.focal, FOCAL);
  gl.uniformMatrix3fv(depths.uniforms.light_axes, false, light_axes);
  gl.colorMask(false, false, false, false);
  gl.drawElements(gl.TRIANGLES, 3 * about.mesh[1], gl.UNSIGNED_INT, 0);
  gl.colorMask(true, true, true, true);
  gl.useProgram(scene.program);
}

// Draws the depths from the light, unless those that are there are of the same light.
function drawShadow(values) {
  const { side, texture, frame } = depthFromLight, light = values.light_axes.join();
  if (!state.shadows || depthFromLight.light === light) return;
  gl.activeTexture(gl.TEXTURE4);
  gl.bindTexture(gl.TEXTURE_2D, null);
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.viewport(0, 0, side, side);
  gl.scissor(0, 0, side, side);
  gl.clear(gl.DEPTH_BUFFER_BIT);
  drawDepths(SHADOW, values);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  depthFromLight.light = light;
  shadowPasses += 1;
}

// Draws the mesh: first its depths, so that each pixel is shaded once.
function drawMesh(values) {
  drawDepths(SHAPE, values);
  gl.uniform1i(uniforms.view, SHAPE);
  gl.drawElements(gl.TRIANGLES, 3 * about.mesh[1], gl.UNSIGNED_INT, 0);
}

// Draws a view, whose uniforms have these `values`, into `target`; of its `rows` only, if they are given as first and number.
function drawInto(target, view, values, rows) {
  const solid = view === SHAPE && state.shape === MESH, [width, height] = values.size;
  if (solid) drawShadow(values);
  gl.bindFramebuffer(gl.FRAMEBUFFER, target);
  gl.viewport(0, 0, width, height);
  gl.scissor(0, rows ? rows[0] : 0, width, rows ? rows[1] : height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.uniform1i(uniforms.view, solid ? BACKDROP : view);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  if (solid) drawMesh(values);
}

// Draws the mesh on the surface with four samples a pixel. Small pictures have one: of a fine mesh, triangles would be shaded that no pixel shows.
function drawSmoothly(view, values, rows) {
  const { width, height } = surface;
  if (!fourfold || fourfold.width !== width || fourfold.height !== height) {
    if (fourfold) {
      gl.deleteFramebuffer(fourfold.frame);
      [fourfold.color, fourfold.depth].forEach((buffer) => gl.deleteRenderbuffer(buffer));
    }
    fourfold = { width, height, frame: gl.createFramebuffer(), color: gl.createRenderbuffer(), depth: gl.createRenderbuffer() };
    gl.bindFramebuffer(gl.FRAMEBUFFER, fourfold.frame);
    for (const [buffer, format, place] of [[fourfold.color, gl.RGBA8, gl.COLOR_ATTACHMENT0], [fourfold.depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, 4, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    }
  }
  drawInto(fourfold.frame, view, values, rows);
  const [first, count] = rows || [0, values.size[1]], box = [0, first, values.size[0], first + count];
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, fourfold.frame);
  gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
  gl.blitFramebuffer(...box, ...box, gl.COLOR_BUFFER_BIT, gl.NEAREST);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
}

// Draws a view into floats and returns them, or nothing where the browser cannot.
function floats(view, values) {
  if (!gl.getExtension("EXT_color_buffer_float")) return undefined;
  const target = gl.createTexture(), depth = gl.createRenderbuffer(), frame = gl.createFramebuffer(), [width, height] = values.size;
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
    drawInto(frame, view, values);
    numbers = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, numbers);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.deleteFramebuffer(frame);
  gl.deleteTexture(target);
  gl.deleteRenderbuffer(depth);
  return numbers;
}
