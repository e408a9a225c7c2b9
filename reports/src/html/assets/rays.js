/** Shows the steps of the rays of the sampled pixel that is nearest to the one of the read-out. */
async function showRays({ every, first, size, sets, operations, ends, lengths, order, ids }) {
  const list = (packed) => unpack(packed, packed.count, 1);
  const [endOf, lengthOf, orderOf] = await Promise.all([ends, lengths, order].map(list));
  const idsOf = await Promise.all(ids.map(list));
  const place = document.getElementById("rays");

  // Where each ray's steps begin, among all and among those of each operation.
  const starts = new Uint32Array(endOf.length);
  const idStarts = operations.map(() => new Uint32Array(endOf.length));
  const seen = operations.map(() => 0);
  for (let ray = 0, step = 0; ray < endOf.length; ray += 1) {
    starts[ray] = step;
    idStarts.forEach((of, operation) => (of[ray] = seen[operation]));
    for (const end = step + lengthOf[ray]; step < end; step += 1) seen[orderOf[step]] += 1;
  }

  const element = (tag, className, ...children) => {
    const made = document.createElement(tag);
    made.className = className;
    made.append(...children);
    return made;
  };
  const ofRay = (ray, set) => {
    const next = idStarts.map((of) => of[ray]);
    const counts = operations.map(() => 0);
    const steps = [];
    for (let step = starts[ray]; step < starts[ray] + lengthOf[ray]; step += 1) {
      const operation = orderOf[step];
      counts[operation] += 1;
      steps.push(element("li", `s${operation}`, `${operations[operation]} ${idsOf[operation][next[operation]++]}`));
    }
    const end = endOf[ray] === 0 ? "not cast" : endOf[ray] === 1 ? "hits nothing" : `hits triangle ${endOf[ray] - 2}`;
    const told = counts.map((count, operation) => count && `${count} × ${operations[operation]}`).filter(Boolean);
    const summary = element("p", "", element("b", "", sets[set]), ` ${[end, ...told].join(", ")}`);
    const open = element("ol", "steps", ...steps);
    open.tabIndex = 0;
    open.setAttribute("aria-label", `Steps of the ${sets[set]} ray`);
    return element("div", "ray", summary, ...(steps.length ? [open] : []));
  };
  let shown = -1;
  return ([x, y]) => {
    const [column, row] = [x, y].map((at, axis) => Math.max(0, Math.min(size[axis] - 1, Math.round((at - first[axis]) / every))));
    const pixel = row * size[0] + column;
    if (pixel === shown) return;
    shown = pixel;
    const title = `Pixel x ${first[0] + every * column}, y ${first[1] + every * row}`;
    place.replaceChildren(element("h4", "", title), ...sets.map((_, set) => ofRay(pixel * sets.length + set, set)));
  };
}
