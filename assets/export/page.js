
// ------------------------------------------------------------------------------------------------ check

// The picture keeps its shape, so that it may be narrower than its box.
function placeBar() {
  const { clientWidth, clientHeight, naturalWidth, naturalHeight } = element("relief");
  const width = Math.min(clientWidth, clientHeight * naturalWidth / Math.max(naturalHeight, 1));
  element("bar").style.width = `${about.bar * width}px`;
}

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
  bindNumbers(2, count, 3, list);
  const found = floats(LIST, setUniforms(LIST, count, 1));
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
  const off = deviation(), line = document.createElement("li");
  line.textContent = off === undefined
    ? "This browser cannot draw floats, so that its colours were not compared with the table."
    : `Drawn by this browser, ${about.directions} directions differ from the 64-bit reading of the table by ${(100 * off).toPrecision(2)} %.`;
  element("trust").append(line);
  document.documentElement.dataset.deviation = off ?? "";
}

// Linear radiance of the shape under a point of light, and in the surroundings if they are on, for tests: rows from the bottom, red, green, blue and cover.
function radiance(width, height) {
  const values = setUniforms(SHAPE, width, height);
  gl.uniform1f(uniforms.light_spread, 0);
  gl.uniform1i(uniforms.as_radiance, 1);
  return floats(SHAPE, values);
}

// ------------------------------------------------------------------------------------------------ begin

// Waits until what the page shows so far is on the screen.
const shown = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)));

// Compiles the programs and gives them all that they read. `wait` is called between the steps, so that hands find the page ready.
async function prepare(wait) {
  openDevice();
  await wait();
  scene = startProgram(text("material") + text("colour") + text("scene"));
  depths = startProgram(DEPTH_ALONE);
  await Promise.all([scene, depths].map(finishProgram));
  uniforms = scene.uniforms;
  await bindAll(wait);
  ready = true;
}

async function begin() {
  placeBar();
  addEventListener("resize", placeBar);
  element("relief").addEventListener("load", placeBar);
  element("meshes").hidden = !about.mesh;
  watchShape();
  watchLight();
  watchControls();
  draw();
  await shown();
  await prepare(shown);
  expose();
  draw();
  await shown();
  check();
  // The first picture has taken longer than those that follow.
  draw();
}

// Shows the still picture and says why nothing else is drawn.
function fail(error) {
  note("failed");
  document.documentElement.classList.add("failed");
  element("still").hidden = false;
  element("failure").hidden = false;
  element("failure").textContent = error.message;
}

note("waiting");
begin().catch(fail);
