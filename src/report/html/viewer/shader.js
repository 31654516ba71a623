// Colours by limit: the same hard steps, hatching and colours as the pictures of the page.

export const VERTEX = `
in float value;
out float v;
out float known;
out vec3 place;
void main() {
  known = value == value ? 1.0 : 0.0;
  v = known > 0.5 ? value : 0.0;
  place = position;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

export const FRAGMENT = `
precision highp float;
#ifdef BACK
const bool back = true;
#else
const bool back = false;
#endif
in float v;
in float known;
in vec3 place;
out vec4 colour;
uniform float low, high, fail, warn, sense, tie, dot_size, capped;
uniform int kind;
uniform vec4 plane;
uniform vec3 lamp;

vec3 rgb(float r, float g, float b) { return vec3(r, g, b) / 255.0; }

vec3 through(vec3 a, vec3 b, vec3 c, vec3 d, float t) {
  t = clamp(t, 0.0, 1.0) * 3.0;
  return t < 1.0 ? mix(a, b, t) : t < 2.0 ? mix(b, c, t - 1.0) : mix(c, d, t - 2.0);
}

float share(float x, float from, float to) { return abs(to - from) > 1e-9 ? (x - from) / (to - from) : 0.0; }

void main() {
  if (dot(plane.xyz, place) + plane.w > 1e-6) discard;
  vec2 px = gl_FragCoord.xy / dot_size;
  if (back && capped > 0.5 && dot(plane.xyz, plane.xyz) > 0.5) {
    float line = step(mod(px.x - px.y, 7.0), 2.2);
    colour = vec4(mix(rgb(150.0, 168.0, 183.0), rgb(186.0, 200.0, 211.0), line), 1.0);
    return;
  }
  vec3 n = normalize(cross(dFdx(place), dFdy(place)));
  bool hasFail = (kind & 1) == 1, hasWarn = (kind & 2) == 2;
  float bad = sense > 0.0 ? low : high, good = sense > 0.0 ? high : low;
  float x = v / max(known, 1e-3);
  vec3 base = rgb(196.0, 203.0, 209.0);
  float dark = 1.0;
  if (known > 0.34) {
    if (hasFail && (x - fail) * sense < -tie) {
      base = through(rgb(140.0, 8.0, 44.0), rgb(186.0, 26.0, 42.0), rgb(222.0, 74.0, 30.0), rgb(240.0, 124.0, 36.0), share(x, bad, fail));
      if (mod(px.x - px.y, 7.0) < 2.0) dark = 0.62;
    } else if (hasWarn && (x - warn) * sense < -tie) {
      base = mix(rgb(247.0, 196.0, 52.0), rgb(251.0, 224.0, 116.0), clamp(share(x, hasFail ? fail : bad, warn), 0.0, 1.0));
      if (mod(px.x + px.y, 11.0) < 1.5) dark = 0.72;
    } else {
      base = mix(rgb(172.0, 192.0, 207.0), rgb(222.0, 231.0, 237.0), clamp(share(x, hasWarn ? warn : hasFail ? fail : bad, good), 0.0, 1.0));
    }
    float w = fwidth(x) * 0.8 * dot_size;
    bool line = (hasFail && abs(x - fail) < w) || (hasWarn && abs(x - warn) < w);
    // A value that leaps from one facet to the next has no line.
    if (line && w > tie && w < 0.1 * (high - low)) { base = rgb(24.0, 33.0, 43.0); dark = 1.0; }
  }
#ifdef FLAT
  float light = 1.0;
#else
  float light = 0.74 + 0.27 * max(dot(n, lamp), 0.0) + 0.03 * n.z;
  if (back) light *= 0.72;
#endif
  colour = vec4(base * light * dark, 1.0);
}`;

export const LINES = `
uniform vec4 plane;
out float beyond;
void main() {
  beyond = dot(plane.xyz, position) + plane.w;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_Position.z -= 2e-4 * gl_Position.w;
}`;

export const INK = `
precision highp float;
in float beyond;
out vec4 colour;
void main() {
  if (beyond > 1e-6) discard;
  colour = vec4(24.0, 33.0, 43.0, 190.0) / 255.0;
}`;
