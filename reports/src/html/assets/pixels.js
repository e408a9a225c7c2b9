/** Draws the maps and tells the figures of the pixel that is pointed at. */
async function showPixels({ size: [width, height], reduce, ramp, none, maps }, showRaysAt) {
  const byId = (id) => document.getElementById(id);
  const [canvas, loupe, mark, scale, readout, pin] = ["map", "loupe", "mark", "scale", "readout", "pin"].map(byId);
  const fields = [byId("at-x"), byId("at-y")];
  const values = await Promise.all(maps.map((map) => unpack(map, width, height)));
  const ranked = maps.map((map, index) => (map.classes.length ? null : values[index].filter((value) => value !== map.none).sort()));

  const colour = (map, value) => {
    if (map.classes.length) return map.classes[value][1];
    if (value === map.none) return none;
    const place = Math.min(value / map.end, 1) * (ramp.length - 1);
    const below = Math.min(Math.floor(place), ramp.length - 2);
    return ramp[below].map((from, channel) => Math.round(from + (ramp[below + 1][channel] - from) * (place - below)));
  };
  const css = (rgb) => `rgb(${rgb.join(" ")})`;
  const number = (value) => value.toLocaleString("en");
  const element = (tag, properties, ...children) => {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...children);
    return made;
  };

  let chosen = 0;
  let at = [Math.floor(width / 2), Math.floor(height / 2)];
  let held = false;
  let painted = null;

  const paint = () => {
    const map = maps[chosen];
    const picture = new ImageData(width, height);
    const known = new Map();
    values[chosen].forEach((value, place) => {
      if (!known.has(value)) known.set(value, colour(map, value));
      const [red, green, blue] = known.get(value);
      picture.data[4 * place] = red;
      picture.data[4 * place + 1] = green;
      picture.data[4 * place + 2] = blue;
      picture.data[4 * place + 3] = 255;
    });
    painted = picture;
    canvas.getContext("2d").putImageData(picture, 0, 0);
    if (map.classes.length) {
      const classes = map.classes.map(([name, rgb]) => {
        const key = element("i", { className: "key" });
        key.style.backgroundColor = css(rgb);
        return element("span", {}, key, name);
      });
      scale.replaceChildren(element("div", { className: "classes" }, ...classes));
    } else {
      const bar = element("div", { className: "ramp" }, element("i", {}));
      bar.style.background = `linear-gradient(to right, ${ramp.map(css).join(", ")})`;
      const most = ranked[chosen].at(-1) ?? 0;
      const end = most > map.end ? `${number(map.end)} ${map.unit} and more, up to ${number(most)}` : `${number(map.end)} ${map.unit}`;
      scale.replaceChildren(bar, element("div", { className: "ends" }, element("span", {}, "0"), element("span", {}, end)));
    }
  };

  /** Part of the pixels whose figure is smaller, in per cent. */
  const rank = (sorted, value) => {
    let [low, high] = [0, sorted.length];
    while (low < high) {
      const middle = (low + high) >>> 1;
      if (sorted[middle] < value) low = middle + 1;
      else high = middle;
    }
    return (100 * low) / sorted.length;
  };

  const tell = () => {
    const [x, y] = at;
    const place = y * width + x;
    fields.forEach((field, axis) => document.activeElement === field || (field.value = at[axis]));
    mark.style.left = `${(100 * (x + 0.5)) / width}%`;
    mark.style.top = `${(100 * (y + 0.5)) / height}%`;
    const rows = maps.map((map, index) => {
      const value = values[index][place];
      const cell = element("td", { className: "n" });
      if (map.classes.length) cell.append(map.classes[value][0]);
      else if (value === map.none) cell.append("none");
      else cell.append(`${number(value)} ${map.unit}`, element("small", {}, `more than ${rank(ranked[index], value).toFixed(1)} % of pixels`));
      cell.dataset.value = value === map.none ? "" : value;
      return element("tr", { className: index === chosen ? "on" : "" }, element("th", { scope: "row" }, map.title), cell);
    });
    readout.replaceChildren(element("tbody", {}, ...rows));
    const slider = scale.querySelector(".ramp i");
    if (slider) slider.style.left = `${100 * Math.min(values[chosen][place] / maps[chosen].end, 1)}%`;
    const context = loupe.getContext("2d");
    const reach = (loupe.width - 1) / 2;
    context.clearRect(0, 0, loupe.width, loupe.height);
    context.putImageData(painted, reach - x, reach - y);
    showRaysAt(at.map((of) => of * reduce));
  };

  const go = (x, y) => {
    at = [Math.max(0, Math.min(width - 1, x)), Math.max(0, Math.min(height - 1, y))];
    tell();
  };
  const hold = (whether) => {
    held = whether;
    pin.setAttribute("aria-pressed", String(held));
  };
  const under = ({ clientX, clientY }) => {
    const box = canvas.getBoundingClientRect();
    go(Math.floor(((clientX - box.left) * width) / box.width), Math.floor(((clientY - box.top) * height) / box.height));
  };
  canvas.addEventListener("pointermove", (event) => held || under(event));
  canvas.addEventListener("click", (event) => {
    under(event);
    hold(!held);
  });
  pin.addEventListener("click", () => hold(!held));
  const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  canvas.addEventListener("keydown", (event) => {
    const step = steps[event.key];
    if (!step) return;
    event.preventDefault();
    hold(true);
    const length = event.shiftKey ? 16 : 1;
    go(at[0] + length * step[0], at[1] + length * step[1]);
  });
  fields.forEach((field) =>
    field.addEventListener("input", () => {
      const place = fields.map((of) => Math.trunc(Number(of.value)));
      if (field.value === "" || place.some(Number.isNaN)) return;
      hold(true);
      go(...place);
    }),
  );
  for (const choice of document.querySelectorAll('input[name="map"]')) {
    choice.addEventListener("change", () => {
      chosen = Number(choice.value);
      paint();
      tell();
    });
    // A browser may keep a choice from before the page was loaded again.
    if (choice.checked) chosen = Number(choice.value);
  }
  paint();
  tell();
}

{
  const data = document.getElementById("map-data");
  const ready = () => (document.body.dataset.ready = "");
  if (!data) ready();
  else if (!("DecompressionStream" in window)) {
    document.querySelector(".viewer").textContent = "This browser cannot unpack the maps; the same pictures lie beside this page as PNG files.";
    ready();
  } else {
    const rays = document.getElementById("ray-data");
    const shown = rays ? showRays(JSON.parse(rays.textContent)) : Promise.resolve(() => {});
    shown.then((showRaysAt) => showPixels(JSON.parse(data.textContent), showRaysAt)).then(ready);
  }
}
