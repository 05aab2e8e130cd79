// What is drawn: an object a run, what does not move, the slice, the mark of an element. Both halves of the picture
// share one camera.

const SPEEDS = ["#0b2f6b", "#1f6fb5", "#5fb3dd", "#b5e2ef", "#e8f7fa"].map((c) => new THREE.Color(c));
const BRICKS = ["#d9cfbd", "#e0a84e", "#d0603c", "#a8333f", "#6a1a3a"].map((c) => new THREE.Color(c));
const APART = ["#dddddd", "#ffe08a", "#f0a030", "#d0403c", "#5a1a5a"].map((c) => new THREE.Color(c));
const PLAIN = { mesh: DATA.colour, surface: "#d9d2c5", liquid: "#3d86c6", bodies: "#d9cfbd", points: "#1f6fb5" };

// The colour at x, 0 to 1, of a table.
function colour_at(table, x, to, k) {
  const at = Math.min(Math.max(x, 0), 1) * (table.length - 1), i = Math.min(Math.floor(at), table.length - 2);
  const t = at - i;
  const a = table[i], b = table[i + 1];
  to[3 * k] = a.r + t * (b.r - a.r), to[3 * k + 1] = a.g + t * (b.g - a.g), to[3 * k + 2] = a.b + t * (b.b - a.b);
}

const colour_of_code = (code, to, k) => colour_at(APART, code ? 0.05 + 0.95 * code / 255 : 0, to, k);

function mesh_of(shape, material) {
  const group = new THREE.Group(), geometry = new THREE.BufferGeometry();
  const points = numbers(shape.points, Float32Array), triangles = numbers(shape.triangles, Uint32Array);
  geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
  if (triangles.length) {
    geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    geometry.computeVertexNormals();
    group.add(new THREE.Mesh(geometry, material));
  }
  const lines = numbers(shape.lines, Uint32Array);
  if (lines.length) {
    const edges = new THREE.BufferGeometry();
    edges.setAttribute("position", geometry.getAttribute("position"));
    edges.setIndex(new THREE.BufferAttribute(lines, 1));
    group.add(new THREE.LineSegments(edges, new THREE.LineBasicMaterial({ color: "#999999" })));
  }
  return group;
}

function fixed_object() {
  const group = new THREE.Group();
  for (const name in DATA.fixed) {
    const glass = name === "obstacles" && DATA.kind === "liquid";
    const colour = name === "ground" ? "#e4e2dd" : glass ? "#9fb8c0" : "#cfcac2";
    group.add(mesh_of(DATA.fixed[name], new THREE.MeshPhongMaterial({
      color: colour, side: THREE.DoubleSide, flatShading: name !== "obstacles", transparent: glass,
      opacity: glass ? 0.25 : 1, depthWrite: !glass, shininess: glass ? 60 : 5,
      polygonOffset: true, polygonOffsetFactor: 4, polygonOffsetUnits: 4 })));
  }
  return group;
}

// Particles as round points, as large as they are far apart.
function points_object(radius) {
  const material = new THREE.ShaderMaterial({
    uniforms: { radius: { value: radius }, pixels: { value: 1 }, opacity: { value: 1 } },
    vertexShader: `attribute vec3 color; uniform float radius, pixels; varying vec3 tint;
      void main() { tint = color; vec4 p = modelViewMatrix * vec4(position, 1.); gl_Position = projectionMatrix * p;
        gl_PointSize = max(2. * radius * pixels * projectionMatrix[1][1] / -p.z, 1.5); }`,
    fragmentShader: `uniform float opacity; varying vec3 tint;
      void main() { vec2 d = 2. * gl_PointCoord - 1.; float r = dot(d, d); if (r > 1.) discard;
        float light = .55 + .45 * (sqrt(1. - r) * .7 - d.y * .4 - d.x * .2);
        gl_FragColor = vec4(tint * light, opacity); }`,
    transparent: true });
  const object = new THREE.Points(new THREE.BufferGeometry(), material);
  object.frustumCulled = false;
  return object;
}

function surface_object(flat) {
  const object = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshPhongMaterial({
    vertexColors: THREE.VertexColors, side: THREE.DoubleSide, flatShading: flat, transparent: true,
    shininess: DATA.kind === "liquid" ? 60 : 8, specular: DATA.kind === "liquid" ? "#666666" : "#222222" }));
  object.frustumCulled = false;
  return object;
}

function set(geometry, name, values, size) {
  const old = geometry.getAttribute(name);
  if (old && old.array.length === values.length) old.array.set(values), old.needsUpdate = true;
  else geometry.setAttribute(name, new THREE.BufferAttribute(values, size));
}

// Corners of all bodies in a frame: each turned and moved with its body.
function corners_of(steps, local, body) {
  const n = DATA.elements, found = new Float32Array(local.length), p = places(steps);
  const part = (k, b) => steps[(3 + k) * n + b] / 65535 * 2 - 1;
  for (let k = 0; k < body.length; ++k) {
    const b = body[k], w = part(0, b), x = part(1, b), y = part(2, b), z = part(3, b);
    const norm = 2 / (w * w + x * x + y * y + z * z);
    const vx = local[3 * k], vy = local[3 * k + 1], vz = local[3 * k + 2];
    const tx = norm * (y * vz - z * vy), ty = norm * (z * vx - x * vz), tz = norm * (x * vy - y * vx);
    found[3 * k] = p[3 * b] + vx + w * tx + y * tz - z * ty;
    found[3 * k + 1] = p[3 * b + 1] + vy + w * ty + z * tx - x * tz;
    found[3 * k + 2] = p[3 * b + 2] + vz + w * tz + x * ty - y * tx;
  }
  return found;
}

// Speed of each element as a share of a fast one, from this frame and one beside it.
async function speeds_of(run, frame) {
  const other = frame % DATA.block ? frame - 1 : Math.min(frame + 1, DATA.frames - 1);
  const a = places(await steps_of(run, frame)), b = places(await steps_of(run, other));
  const found = new Float32Array(DATA.elements);
  for (let k = 0; k < found.length; ++k)
    found[k] = Math.hypot(a[3 * k] - b[3 * k], a[3 * k + 1] - b[3 * k + 1], a[3 * k + 2] - b[3 * k + 2]) / DATA.fast;
  return found;
}

// Colours of points: by distance, by speed, or plain. `body` names the element of each point where that is another.
async function colours_of(run, frame, over, body) {
  const n = body ? body.length : DATA.elements, found = new Float32Array(3 * n);
  const moves = DATA.kind === "points" || DATA.kind === "bodies";
  const codes = over ? await apart_of(frame) : undefined;
  const speeds = !over && moves ? await speeds_of(run, frame) : undefined;
  const plain = new THREE.Color(over ? APART[0] : PLAIN[DATA.kind]);
  for (let k = 0; k < n; ++k) {
    const element = body ? body[k] : k;
    if (codes) colour_of_code(codes[element], found, k);
    else if (speeds && DATA.kind === "bodies") colour_at(BRICKS, speeds[element], found, k);
    else if (speeds) colour_at(SPEEDS, speeds[element], found, k);
    else plain.toArray(found, 3 * k);
  }
  return found;
}

// An object that shows a run: `show(frame, over)` puts a frame into it.
function run_object(run) {
  const kind = DATA.kind, group = new THREE.Group();
  if (kind === "points") {
    const points = points_object(DATA.radius);
    group.add(points);
    group.show = async (frame, over) => {
      const steps = await steps_of(run, frame), colours = await colours_of(run, frame, over);
      set(points.geometry, "position", places(steps), 3);
      set(points.geometry, "color", colours, 3);
    };
  } else if (kind === "bodies" || kind === "mesh") {
    const of_bodies = kind === "bodies", surface = surface_object(of_bodies);
    const local = of_bodies ? numbers(DATA.bodies.points, Float32Array) : undefined;
    const body = of_bodies ? numbers(DATA.bodies.body, Uint32Array) : undefined;
    const triangles = numbers(of_bodies ? DATA.bodies.triangles : DATA.triangles, Uint32Array);
    surface.geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    group.add(surface);
    group.show = async (frame, over) => {
      const steps = await steps_of(run, frame), colours = await colours_of(run, frame, over, body);
      set(surface.geometry, "position", of_bodies ? corners_of(steps, local, body) : places(steps), 3);
      set(surface.geometry, "color", colours, 3);
      if (!of_bodies) surface.geometry.computeVertexNormals();
    };
  } else {
    const surface = surface_object(false), drops = points_object(0.3 * DATA.slice.spacing);
    group.add(surface, drops);
    group.show = async (frame, over) => {
      const { places: at, corners, spray, codes } = await block(`run${run}-${frame}`, surface_of);
      const colours = new Float32Array(at.length), plain = new THREE.Color(over ? APART[0] : PLAIN[kind]);
      for (let k = 0; k < at.length / 3; ++k)
        over && codes ? colour_of_code(codes[k], colours, k) : plain.toArray(colours, 3 * k);
      surface.geometry.dispose();
      surface.geometry = new THREE.BufferGeometry();
      surface.geometry.setIndex(new THREE.BufferAttribute(corners, 1));
      surface.geometry.setAttribute("position", new THREE.BufferAttribute(at, 3));
      surface.geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
      surface.geometry.computeVertexNormals();
      const tint = new Float32Array(spray.length);
      for (let k = 0; k < spray.length / 3; ++k) plain.toArray(tint, 3 * k);
      set(drops.geometry, "position", spray, 3);
      set(drops.geometry, "color", tint, 3);
    };
  }
  // Translucent, in one colour: what the other run is compared with.
  group.fade = (opacity) => group.traverse((part) => {
    if (!part.material) return;
    if (part.material.uniforms) part.material.uniforms.opacity.value = opacity;
    else part.material.opacity = opacity;
    part.material.depthWrite = opacity === 1;
  });
  return group;
}

// The slice through the middle of a level set: pale at the surface, blue within, orange without.
function slice_object(run) {
  const { columns, rows, corner, spacing } = DATA.slice;
  const texels = new Uint8Array(4 * columns * rows);
  const texture = new THREE.DataTexture(texels, columns, rows, THREE.RGBAFormat);
  texture.magFilter = texture.minFilter = THREE.NearestFilter;
  const object = new THREE.Mesh(new THREE.PlaneBufferGeometry(columns * spacing, rows * spacing),
    new THREE.MeshBasicMaterial({ map: texture, side: THREE.DoubleSide }));
  object.position.set(corner[0] + spacing * (columns - 1) / 2, corner[1] + spacing * (rows - 1) / 2, corner[2]);
  object.show = async (frame) => {
    const values = await block(`slice${run}-${frame}`, (bytes) => bytes);
    for (let k = 0; k < values.length; ++k) {
      const d = (values[k] - 127.5) / 127.5, strength = Math.round(60 + 150 * Math.abs(d));
      const weak = 255 - strength, half = 255 - strength / 2;
      texels.set(d < 0 ? [weak, half, 255, 255] : [255, half, weak, 255], 4 * k);
    }
    texture.needsUpdate = true;
  };
  return object;
}
