// Reads the report's GLB: one mesh, positions in 16 bits under a node's scale, one attribute for each map.

/** Positions (mm), indices and maps of a GLB made by amcheck. */
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
  const primitive = json.meshes[0].primitives[0], node = json.nodes[0];
  const grid = read(primitive.attributes.POSITION);
  const positions = new Float32Array(grid.length);
  for (let i = 0; i < grid.length; i++) positions[i] = (grid[i] / 65535) * node.scale[i % 3] + node.translation[i % 3];
  const maps = json.meshes[0].extras.maps.map((m) => {
    const codes = read(primitive.attributes[m.attribute]);
    const values = new Float32Array(codes.length);
    for (let i = 0; i < codes.length; i++) {
      values[i] = codes[i] === 65535 ? NaN : m.low + (codes[i] / 65534) * (m.high - m.low);
    }
    return { ...m, values };
  });
  return { positions, indices: Uint32Array.from(read(primitive.indices)), maps };
}
