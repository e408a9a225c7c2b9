/** The values of a map, row by row: the inverse of html/packed.rs. */
async function unpack({ divisor, planes, data }, width, height) {
  const deflated = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = width * height;
  const values = new Uint32Array(count);
  for (let place = 0; place < count; place += 1) {
    let folded = 0;
    for (let plane = 0; plane < planes; plane += 1) folded |= bytes[plane * count + place] << (8 * plane);
    const difference = (folded >>> 1) ^ -(folded & 1);
    const left = place % width > 0;
    const up = place >= width;
    let predicted = 0;
    if (left && up) predicted = medianEdge(values[place - 1], values[place - width], values[place - width - 1]);
    else if (left) predicted = values[place - 1];
    else if (up) predicted = values[place - width];
    values[place] = predicted + difference;
  }
  return divisor === 1 ? values : values.map((value) => value * divisor);
}

/** The prediction of LOCO-I. */
function medianEdge(left, up, corner) {
  if (corner >= Math.max(left, up)) return Math.min(left, up);
  if (corner <= Math.min(left, up)) return Math.max(left, up);
  return left + up - corner;
}
