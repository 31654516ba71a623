// Shapes that can be shown with the part: supports, trapped volumes, what no tool reaches, as printed.
import { BufferAttribute, BufferGeometry, DoubleSide, GLSL3, Mesh, ShaderMaterial } from "three";

const VERTEX = `
out vec3 place;
void main() {
  place = position;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const FRAGMENT = `
precision highp float;
in vec3 place;
out vec4 colour;
uniform vec3 lamp, tint;
uniform vec4 plane;
void main() {
  if (dot(plane.xyz, place) + plane.w > 1e-6) discard;
  vec3 n = normalize(cross(dFdx(place), dFdy(place)));
  colour = vec4(tint * (0.72 + 0.28 * max(dot(n, lamp), 0.0)), 0.82);
}`;

/** One tint for each layer, apart from the colours of limits. */
const TINTS = [[0.36, 0.36, 0.78], [0.1, 0.55, 0.6], [0.62, 0.28, 0.68], [0.24, 0.5, 0.24]];

/** A check box for each layer in `group`; a layer is drawn over the part, so that what is inside is seen. */
export function addLayers(view, group) {
  view.model.layers.forEach((layer, i) => {
    const g = new BufferGeometry();
    g.setAttribute("position", new BufferAttribute(layer.positions, 3));
    g.setIndex(new BufferAttribute(layer.indices, 1));
    const material = new ShaderMaterial({
      glslVersion: GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT, side: DoubleSide, transparent: true,
      uniforms: { lamp: view.material.uniforms.lamp, plane: view.material.uniforms.plane, tint: { value: TINTS[i % TINTS.length] } },
    });
    const mesh = new Mesh(g, material);
    mesh.visible = false;
    // It hides itself as a solid does, and nothing of the part hides it.
    mesh.onBeforeRender = (gl) => gl.clearDepth();
    mesh.renderOrder = 2;
    view.scene.add(mesh);
    const box = Object.assign(document.createElement("input"), { type: "checkbox" });
    box.addEventListener("change", () => { mesh.visible = box.checked; view.draw(); });
    const label = document.createElement("label");
    label.append(box, " " + layer.title);
    group.append(label);
  });
}
