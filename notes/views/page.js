// The page: one camera over one or two runs, buttons, curves, and the address, such as #frame=12&mode=over&play.
// `document.body.dataset` says what is shown, for tests.

const $ = (id) => document.getElementById(id), shown = document.body.dataset;

function fail(text) {
  shown.error = text;
  const message = document.createElement("p");
  message.id = "message", message.className = "failed", message.textContent = text;
  $("stage").appendChild(message);
}
addEventListener("error", (event) => fail(event.message));
addEventListener("unhandledrejection", (event) => fail(String(event.reason)));

const words = new URLSearchParams(location.hash.slice(1));
const last = DATA.frames - 1, two = DATA.runs.length === 2;
const within = (frame) => Math.min(Math.max(frame, 0), last);
const state = { frame: within(Number(words.get("frame")) || 0), playing: false, slice: words.has("slice"),
  mode: two && words.get("mode") === "over" ? "over" : "beside", marked: undefined };
let show_picture = async () => {};

function picture() {
  const renderer = new THREE.WebGLRenderer({ antialias: true });  // throws where there is no WebGL
  renderer.setPixelRatio(devicePixelRatio);
  renderer.setClearColor("#f4f4f2");
  $("stage").appendChild(renderer.domElement);
  const [low, high] = DATA.near.map((corner) => new THREE.Vector3(...corner));
  const middle = low.clone().add(high).multiplyScalar(0.5), size = Math.max(high.distanceTo(low), 1e-6 * DATA.size);
  const camera = new THREE.PerspectiveCamera(30, 1, size / 200, Math.max(40 * size, 4 * DATA.size));
  const from = DATA.kind === "mesh" ? [0.35, 0.25, 1] : [0.55, 0.4, 1];
  camera.position.copy(middle).addScaledVector(new THREE.Vector3(...from).normalize(), 2.1 * size);
  const controls = new THREE.OrbitControls(camera, renderer.domElement);
  controls.target.copy(middle);
  controls.update();

  const scene = new THREE.Scene(), light = new THREE.DirectionalLight("#ffffff", 0.65);
  scene.add(new THREE.HemisphereLight("#ffffff", "#9a9488", 0.45), light, light.target);
  light.target.position.copy(middle);
  scene.add(fixed_object());
  // Runs with the same bits share one object, which both halves of the picture show.
  const objects = [run_object(0)], slices = DATA.slice ? [slice_object(0)] : [];
  if (two && !DATA.same) {
    objects.push(run_object(1));
    if (DATA.slice) slices.push(slice_object(1));
  }
  scene.add(...objects, ...slices);
  const mark = new THREE.Mesh(new THREE.SphereBufferGeometry(1, 24, 16),
    new THREE.MeshBasicMaterial({ color: "#ff00aa", depthTest: false, transparent: true, opacity: 0.55 }));
  mark.renderOrder = 9;
  scene.add(mark);

  function draw() {
    const width = $("stage").clientWidth, height = $("stage").clientHeight;
    renderer.setSize(width, height, false);
    const panes = state.mode === "beside" && two ? 2 : 1;
    camera.aspect = width / panes / height;
    camera.updateProjectionMatrix();
    light.position.copy(camera.position).addScaledVector(new THREE.Vector3(-0.4, 0.9, 0.2), size);
    renderer.setScissorTest(true);
    for (let pane = 0; pane < panes; ++pane) {
      const one = objects.length === 1, over = state.mode === "over" && two;
      objects.forEach((object, k) => {
        object.visible = over || one || k === pane;
        object.fade(over && !one && k === 0 ? 0.35 : 1);
        object.traverse((part) => {
          const uniforms = part.material && part.material.uniforms;
          if (uniforms) uniforms.pixels.value = height * devicePixelRatio / 2;
        });
      });
      slices.forEach((object, k) => { object.visible = state.slice && (one || k === (over ? 1 : pane)); });
      mark.visible = state.marked !== undefined && state.marked.frame === state.frame;
      if (mark.visible) {
        mark.position.set(...state.marked.place);
        mark.scale.setScalar(0.012 * camera.position.distanceTo(mark.position));
      }
      const x = Math.round(pane * width / panes), w = Math.round((pane + 1) * width / panes) - x;
      renderer.setViewport(x, 0, w, height), renderer.setScissor(x, 0, w, height);
      renderer.render(scene, camera);
    }
    shown.drawn = Number(shown.drawn || 0) + 1;
  }
  controls.addEventListener("change", draw);
  addEventListener("resize", draw);
  return async () => {
    const over = state.mode === "over" && two;
    await Promise.all([...objects.map((object) => object.show(state.frame, over)),
      ...(state.slice ? slices.map((object) => object.show(state.frame)) : [])]);
    draw();
  };
}

function labels() {
  document.querySelectorAll(".label").forEach((label) => label.remove());
  const [first, second] = DATA.runs, over = state.mode === "over" && two;
  const names = over ? [`${second}, coloured by its distance from ${first}`] : DATA.runs;
  names.forEach((name, k) => {
    const label = document.createElement("span");
    label.className = "label", label.textContent = name;
    label.style.left = `calc(${100 * k / names.length}% + .5em)`;
    $("stage").appendChild(label);
  });
  $("legend") && $("legend").remove();
  const speeds = DATA.kind === "points" || DATA.kind === "bodies";
  if (!over && !(speeds && DATA.time_step)) return;
  const legend = document.createElement("span"), bar = document.createElement("i");
  const table = over ? APART : DATA.kind === "points" ? SPEEDS : BRICKS;
  bar.style.background = `linear-gradient(90deg, ${table.map((c) => "#" + c.getHexString()).join(", ")})`;
  const most = over ? `${DATA.size.toPrecision(2)} m, by the logarithm`
    : `${(DATA.fast / DATA.time_step).toPrecision(2)} m/s`;
  legend.id = "legend";
  legend.append(over ? `the same bits${DATA.same ? " everywhere" : ""}` : "0", bar, most);
  $("stage").appendChild(legend);
}

function apart_in_words(row) {
  if (row.most === 0) return "the same in both";
  const [most, rms] = [row.most, row.rms].map((distance) => distance.toPrecision(3));
  return `largest distance ${most} m, of ${DATA.element} ${row.element}; rms ${rms} m`;
}

let showing = Promise.resolve(), marks = [];
// Shows what `state` says, one frame after another.
function show() {
  showing = showing.then(async () => {
    const { frame, marked } = state, row = DATA.rows[frame];
    await show_picture();
    marks.forEach((mark) => mark(frame));
    $("frame").value = frame;
    const seconds = DATA.time_step ? `, ${(frame * DATA.time_step).toFixed(3)} s` : "";
    $("time").textContent = `frame ${frame} of ${last}${seconds}`;
    $("said").textContent = (row ? `Frame ${frame}: ${apart_in_words(row)}. ` : "")
      + (marked && marked.frame === frame ? marked.text : "");
    if (row) shown.most = row.most, shown.rms = row.rms;
    shown.frame = frame, shown.mode = state.mode, shown.state = "ready";
  });
  return showing;
}

async function go(frame, marked) {
  state.frame = within(frame);
  state.marked = marked;
  return show();
}

// Jumps to a frame and marks the element that is farthest from the other run there.
function go_and_mark(frame) {
  frame = within(frame);
  const row = DATA.rows[frame];
  const text = row && `Marked: ${DATA.element} ${row.element}.`;
  return go(frame, row && row.most > 0 ? { frame, place: row.place, text } : undefined);
}

async function go_to_worst() {
  const { frame, element } = DATA.verify_worst, steps = await steps_of(DATA.same ? 0 : 1, frame);
  const place = Array.from(places(steps).slice(3 * element, 3 * element + 3));
  return go(frame, { frame, place, text: `Marked: ${DATA.element} ${element}, which verify's row names.` });
}

async function play(playing) {
  if (playing === state.playing) return;
  state.playing = playing;
  $("play_button").textContent = playing ? "pause" : "play";
  let at = state.frame >= last ? 0 : state.frame, before = performance.now();
  while (state.playing && at < last) {
    await new Promise((resolve) => setTimeout(resolve, 16));
    const now = performance.now(), step = DATA.time_step || 1;
    at = Math.min(at + Math.min((now - before) / 1000, 0.25) * Number($("speed").value) / step, last);
    before = now;
    if (Math.floor(at) !== state.frame && state.playing) await go(Math.floor(at));
  }
  if (state.playing) play(false);
}

function start() {
  $("title").textContent = `${DATA.scene}: ` + (two ? "serial and openmp" : DATA.runs[0]);
  const all = ` All ${DATA.frames} frames here have the same bits in both runs.`;
  const bits = DATA.same ? all : " The runs here differ.";
  $("verdict").textContent = DATA.verdict + (two ? bits : "");
  $("verdict").className = two && DATA.verdict && !DATA.passed ? "failed" : "";
  $("frame").max = last;
  $("mode").value = state.mode, $("slice_box").checked = state.slice;
  $("mode_of").hidden = !two, $("slice_of").hidden = !DATA.slice;
  $("worst_button").hidden = !DATA.verify_worst || !!DATA.slice || DATA.verify_worst.frame > last;
  marks = DATA.curves.map((curve) => draw_curve(curve, $("curves"), go_and_mark));
  if (!window.DecompressionStream) return fail("This browser is too old: it cannot inflate (no DecompressionStream).");
  try {
    show_picture = picture();
  } catch (error) {
    fail("This browser has no WebGL, which the picture needs; the curves below do not.");
    shown.error = `no WebGL: ${error}`;
  }
  $("play_button").onclick = () => play(!state.playing);
  $("back").onclick = () => (play(false), go(state.frame - 1));
  $("forward").onclick = () => (play(false), go(state.frame + 1));
  $("frame").oninput = () => (play(false), go(Number($("frame").value)));
  $("mode").onchange = () => (state.mode = $("mode").value, labels(), show());
  $("slice_box").onchange = () => (state.slice = $("slice_box").checked, show());
  $("worst_button").onclick = () => (play(false), go_to_worst());
  addEventListener("keydown", (event) => {
    if (["SELECT", "INPUT", "BUTTON"].includes(event.target.tagName)) return;
    const does = { " ": "play_button", ArrowLeft: "back", ArrowRight: "forward" }[event.key];
    if (does) event.preventDefault(), $(does).click();
  });
  labels();
  const named = words.has("worst") && !$("worst_button").hidden;
  const first = named ? go_to_worst() : words.has("mark") ? go_and_mark(state.frame) : show();
  first.then(() => words.has("play") && play(true));
}
start();
