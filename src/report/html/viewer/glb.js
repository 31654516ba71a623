// Reads the report's GLB: the part, positions in 16 bits under a node's scale, one attribute for each map; its layers.

/** Positions (mm, and in 16-bit steps), indices, maps and layers of a GLB made by amcheck. */
export function readGlb(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (view.getUint32(0, true) !== 0x46546c67) throw new Error("not a GLB");
  const length = view.getUint32(12, true);
  const json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
  const start = bytes.byteOffset + 28 + length;
  const read = (index) => {
    const a = json.accessors[index], v = json.bufferViews[a.bufferView];
    const Kind = { 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array }[a.componentType];
    const width = { SCALAR: 1, VEC3: 3 }[a.type];
    const from = start + (v.byteOffset ?? 0), stride = v.byteStride ?? width * Kind.BYTES_PER_ELEMENT;
    const all = new Kind(bytes.buffer.slice(from, from + v.byteLength));
    const step = stride / Kind.BYTES_PER_ELEMENT;
    if (step === width) return all.subarray(0, a.count * width);
    const out = new Kind(a.count * width);
    for (let i = 0; i < a.count; i++) for (let k = 0; k < width; k++) out[i * width + k] = all[i * step + k];
    return out;
  };
  const node = json.nodes[0];
  const mesh = ({ primitives: [primitive] }) => {
    const grid = read(primitive.attributes.POSITION), positions = new Float32Array(grid.length);
    for (let i = 0; i < grid.length; i++) positions[i] = (grid[i] / 65535) * node.scale[i % 3] + node.translation[i % 3];
    return { grid, positions, indices: Uint32Array.from(read(primitive.indices)) };
  };
  const [part, ...others] = json.meshes;
  const maps = part.extras.maps.map((m) => {
    const codes = read(part.primitives[0].attributes[m.attribute]);
    const values = new Float32Array(codes.length);
    for (let i = 0; i < codes.length; i++) {
      values[i] = codes[i] === 65535 ? NaN : m.low + (codes[i] / 65534) * (m.high - m.low);
    }
    return { ...m, values };
  });
  return { ...mesh(part), coarse: part.extras.coarse, maps, layers: others.map((o) => ({ title: o.extras.title, ...mesh(o) })) };
}
