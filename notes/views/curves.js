// Curves over frames: a click goes to the frame.

const COLOURS = ["#0072B2", "#D55E00", "#009E73", "#000000"], DASHES = ["", "6 4", "2 3", "10 3"];

function svg(name, attributes, parent, text) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes) element.setAttribute(key, attributes[key]);
  if (text !== undefined) element.textContent = text;
  if (parent) parent.appendChild(element);
  return element;
}

// Draws one curve and returns a function that marks a frame in it.
function draw_curve(curve, parent, go) {
  const width = 1200, height = 150, left = 70, right = 10, top = 20, bottom = 22;
  const picture = svg("svg", { viewBox: `0 0 ${width} ${height}`, preserveAspectRatio: "none" }, parent);
  svg("text", { x: left, y: 13 }, picture, curve.title);
  const shown = curve.lines.flatMap((line) => line.values).filter((v) => !curve.log || v > 0);
  const last = Math.max(DATA.frames - 1, 1);
  const x_of = (frame) => left + (width - left - right) * frame / last;
  let x = left + 8 * curve.title.length + 20;
  curve.lines.forEach((line, k) => {
    const look = { stroke: COLOURS[k], "stroke-width": 2, "stroke-dasharray": DASHES[k] };
    svg("line", { x1: x, x2: x + 22, y1: 9, y2: 9, ...look }, picture);
    svg("text", { x: x + 26, y: 13 }, picture, line.label);
    x += 50 + 7 * line.label.length;
  });
  if (shown.length) {
    const scale = (v) => curve.log ? Math.log10(v) : v;
    let low = Math.min(...shown.map(scale)), high = Math.max(...shown.map(scale));
    if (low === high) low -= Math.abs(low) / 2 || 1, high += Math.abs(high) / 2 || 1;
    const y_of = (v) => height - bottom - (height - top - bottom) * (scale(v) - low) / (high - low);
    for (const [value, y] of [[low, height - bottom], [high, top + 8]])
      svg("text", { x: left - 6, y, "text-anchor": "end" }, picture, (curve.log ? 10 ** value : value).toPrecision(3));
    curve.lines.forEach((line, k) => {
      let path = "", drawn = false;
      line.values.forEach((v, i) => {
        const fits = !curve.log || v > 0;
        if (fits) path += `${drawn ? "L" : "M"}${x_of(line.from + i).toFixed(1)} ${y_of(v).toFixed(1)}`;
        drawn = fits;
      });
      const look = { fill: "none", stroke: COLOURS[k], "stroke-width": 1.5, "stroke-dasharray": DASHES[k] };
      svg("path", { d: path, ...look }, picture);
    });
  } else {
    svg("text", { x: left + 10, y: height / 2 }, picture, "0 in all frames");
  }
  svg("path", { d: `M${left} ${top}V${height - bottom}H${width - right}`, fill: "none", stroke: "#999" }, picture);
  for (const frame of [0, last])
    svg("text", { x: x_of(frame), y: height - 6, "text-anchor": frame ? "end" : "start" }, picture, `frame ${frame}`);
  const mark = svg("line", { y1: top, y2: height - bottom, stroke: "#222" }, picture);
  picture.addEventListener("click", (event) => {
    const place = (event.clientX - picture.getBoundingClientRect().left) / picture.clientWidth * width;
    go(Math.round((place - left) / (width - left - right) * last));
  });
  return (frame) => { mark.setAttribute("x1", x_of(frame)), mark.setAttribute("x2", x_of(frame)); };
}
