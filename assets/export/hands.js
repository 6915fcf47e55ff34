
// ------------------------------------------------------------------------------------------------ hands

const pointers = new Map();
const SLIDERS = ["exposure", "spread", "pigment", "brightness"];

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
  for (const id of SLIDERS) {
    element(id).addEventListener("input", () => draw(true));
    element(id).addEventListener("change", () => draw());
  }
  element("around").addEventListener("change", () => {
    expose();
    draw();
  });
  element("sweep").addEventListener("click", sweep);
  element("reset").addEventListener("click", () => {
    stopSweep();
    state = { ...initial(), shape: state.shape };
    for (const id of SLIDERS) element(id).value = element(id).defaultValue;
    element("around").checked = true;
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
