// Shaders of the scene. Colours are sRGB numbers throughout; where light is added up, a square and a root stand for the
// curve of a screen. Light comes with the camera: what is looked at is never in the dark, and a colour that faces the
// viewer is the colour of the legend.

/** Of everything that carries a field: position on the colour map, level of the domain, colour of its own. */
const fieldVertex = /* glsl */ `
  attribute float value;
  attribute float level;
  varying float vValue;
  varying float vLevel;
  #ifdef COLOURS
    attribute vec3 rgb;
    varying vec3 vColour;
  #endif
  void passField() {
    vValue = value;
    vLevel = level;
    #ifdef COLOURS
      vColour = rgb;
    #endif
  }
`;

const fieldFragment = /* glsl */ `
  uniform float pixels;       // of the drawing, for each of the page
  uniform sampler2D map;
  uniform vec2 ends;          // positions of the scale's ends
  uniform vec3 plain;
  uniform vec3 noValue;
  varying float vValue;
  varying float vLevel;
  #ifdef COLOURS
    varying vec3 vColour;
  #endif
  #ifdef ISOLINES
    uniform vec3 isolines;    // position of a line, distance of lines, position of zero (or far away)
  #endif
  #ifdef DOMAIN
    uniform vec3 inside;
    uniform vec3 ring;
    uniform vec3 rim;
  #endif

  vec3 fieldColour() {
    #if defined(COLOURS)
      vec3 c = vColour;
    #elif defined(SCALAR)
      vec3 c = vValue > 1e19 ? noValue : texture2D(map, vec2(clamp(vValue, ends.x, ends.y), 0.5)).rgb;
    #else
      vec3 c = plain;
    #endif
    #ifdef DOMAIN
      // Solved for, and the ring around; the mesh outside keeps its colour.
      float pixel = max(fwidth(vLevel), 1e-6);
      c = mix(c, mix(ring, inside, smoothstep(-0.5, 0.5, (vLevel - 1.5) / pixel)), 0.72 * smoothstep(-0.5, 0.5, (vLevel - 0.5) / pixel));
      c = mix(c, rim, 1.0 - smoothstep(0.6, 1.4, abs(vLevel - 0.5) / pixel));
    #endif
    return c;
  }

  #ifdef ISOLINES
    vec3 withIsolines(vec3 c) {
      if (vValue > 1e19) return c;
      float slope = max(fwidth(vValue), 1e-12);
      float lines = (vValue - isolines.x) / isolines.y;
      float away = abs(fract(lines + 0.5) - 0.5) * isolines.y / slope;
      float zero = abs(vValue - isolines.z) / slope;
      // Lines that would run together fade out.
      float sparse = 1.0 - smoothstep(0.18, 0.4, slope / isolines.y);
      float thick = 1.1 * pixels;
      float ink = 0.55 * sparse * (1.0 - smoothstep(0.5 * thick - 0.5, 0.5 * thick + 0.5, away));
      ink = max(ink, 0.9 * (1.0 - smoothstep(thick - 0.5, thick + 0.5, zero)));
      return mix(c, vec3(0.03, 0.04, 0.06), ink);
    }
  #endif
`;

export const surfaceVertex = /* glsl */ `
  ${fieldVertex}
  varying vec3 vNormal;
  varying vec3 vToCamera;
  void main() {
    passField();
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    vNormal = normalMatrix * normal;
    #ifdef FACETS
      vToCamera = -place.xyz; // its slope is that of the facet
    #else
      vToCamera = normalize(-place.xyz);
    #endif
    gl_Position = projectionMatrix * place;
  }
`;

export const surfaceFragment = /* glsl */ `
  ${fieldFragment}
  uniform vec3 skyward;       // up, as the camera has it
  varying vec3 vNormal;
  varying vec3 vToCamera;
  void main() {
    #ifdef FACETS
      vec3 toCamera = normalize(vToCamera);
      vec3 n = normalize(cross(dFdx(vToCamera), dFdy(vToCamera)));
    #else
      vec3 toCamera = vToCamera;
      // Zero at vertices that have none of their own: the others of the triangle decide.
      vec3 n = dot(vNormal, vNormal) > 0.0 ? normalize(vNormal) : toCamera;
    #endif
    // Both sides are lit, whichever way a triangle is turned.
    float facing = dot(n, toCamera);
    n = facing < 0.0 ? -n : n;
    facing = abs(facing);
    float key = max(dot(n, vec3(-0.32, 0.46, 0.83)), 0.0);
    float sky = 0.5 + 0.5 * dot(n, skyward);
    float light = 0.17 + 0.19 * sky + 0.27 * facing + 0.42 * key;
    vec3 c = fieldColour();
    #ifdef ISOLINES
      c = withIsolines(c);
    #endif
    vec3 lit = c * c * light;
    #ifdef GLOSS
      float shine = max(dot(n, normalize(toCamera + vec3(-0.32, 0.46, 0.83))), 0.0);
      shine *= shine; shine *= shine; shine *= shine; shine *= shine; shine *= shine;
      lit += 0.05 * shine;
    #endif
    gl_FragColor = vec4(sqrt(lit), 1.0);
  }
`;

/** Points: discs with a little roundness, of a size in pixels that follows the distance. */
export const pointVertex = /* glsl */ `
  ${fieldVertex}
  uniform float pointSize;    // in the mesh's unit
  uniform vec2 resolution;
  void main() {
    passField();
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    gl_PointSize = clamp(pointSize * projectionMatrix[1][1] * 0.5 * resolution.y / gl_Position.w, 2.0, 48.0);
  }
`;

export const pointFragment = /* glsl */ `
  ${fieldFragment}
  void main() {
    vec2 p = 2.0 * gl_PointCoord - 1.0;
    float r = dot(p, p);
    if (r > 1.0) discard;
    vec3 c = fieldColour();
    float light = 0.55 + 0.45 * sqrt(1.0 - r);
    gl_FragColor = vec4(sqrt(c * c * light), 1.0);
  }
`;

/** Lines some pixels wide: an instance is a segment, a quad that faces the screen. */
export const thickVertex = /* glsl */ `
  attribute vec3 from;
  attribute vec3 to;
  attribute vec2 values;      // of both ends
  attribute vec2 levels;
  #ifdef COLOURS
    attribute vec3 rgbFrom;
    attribute vec3 rgbTo;
    varying vec3 vColour;
  #endif
  uniform vec2 resolution;
  uniform float width;        // in pixels of the page
  uniform float pixels;
  uniform float nearer;       // how far toward the camera, of the distance: lines lie on the surface
  varying float vValue;
  varying float vLevel;
  varying float vAcross;
  void main() {
    bool start = position.x < 0.5;
    vValue = start ? values.x : values.y;
    vLevel = start ? levels.x : levels.y;
    #ifdef COLOURS
      vColour = start ? rgbFrom : rgbTo;
    #endif
    vec4 a = modelViewMatrix * vec4(from, 1.0);
    vec4 b = modelViewMatrix * vec4(to, 1.0);
    // What is behind the camera is cut off: its direction on the screen would be the opposite.
    float near = -1.001 * projectionMatrix[3][2] / (projectionMatrix[2][2] - 1.0);
    if (a.z > near && b.z < near) a = mix(a, b, (near - a.z) / (b.z - a.z));
    if (b.z > near && a.z < near) b = mix(b, a, (near - b.z) / (a.z - b.z));
    vec4 p = projectionMatrix * vec4(a.xyz * (1.0 - nearer), 1.0);
    vec4 q = projectionMatrix * vec4(b.xyz * (1.0 - nearer), 1.0);
    vec2 along = (q.xy / q.w - p.xy / p.w) * resolution;
    float size = length(along);
    along = size > 1e-6 ? along / size : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x);
    float reach = 0.5 * width * pixels + 0.5;  // half a pixel more, to fade
    vAcross = position.y * reach;
    vec4 corner = start ? p : q;
    // A little longer than they are, so that neighbours meet.
    vec2 offset = across * vAcross + along * (position.x - 0.5) * width * pixels * 0.7;
    corner.xy += 2.0 * offset / resolution * corner.w;
    gl_Position = corner;
  }
`;

export const thickFragment = /* glsl */ `
  ${fieldFragment}
  uniform float width;
  varying float vAcross;
  void main() {
    float alpha = clamp(0.5 * width * pixels + 0.5 - abs(vAcross), 0.0, 1.0);
    if (alpha < 0.02) discard;
    gl_FragColor = vec4(fieldColour(), alpha);
  }
`;

/** Edges of triangles: one pixel wide, paler where they would cover the surface. */
export const wireVertex = /* glsl */ `
  uniform vec2 resolution;
  uniform float edge;         // mean length
  varying float vInk;
  void main() {
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    place.xyz *= 0.9996;
    gl_Position = projectionMatrix * place;
    float pixels = edge * projectionMatrix[1][1] * 0.5 * resolution.y / gl_Position.w;
    vInk = smoothstep(1.5, 11.0, pixels);
  }
`;

export const wireFragment = /* glsl */ `
  uniform vec4 ink;
  varying float vInk;
  void main() {
    gl_FragColor = vec4(ink.rgb, ink.a * (0.12 + 0.88 * vInk));
  }
`;

/** Balls of a constant size in pixels. */
export const markerVertex = /* glsl */ `
  attribute vec3 colour;
  uniform float size;
  uniform float depth;        // how far a ball stands out of the surface, of its distance
  varying vec3 vColour;
  void main() {
    vColour = colour;
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    vec4 seen = projectionMatrix * place;
    place.xyz *= 1.0 - depth;
    vec4 front = projectionMatrix * place;
    gl_Position = vec4(seen.xy, front.z / front.w * seen.w, seen.w);
    gl_PointSize = size;
  }
`;

export const markerFragment = /* glsl */ `
  uniform vec3 halo;
  uniform float size;
  varying vec3 vColour;
  void main() {
    vec2 p = (2.0 * gl_PointCoord - 1.0) * vec2(1.0, -1.0);
    float r = length(p);
    float pixel = 2.0 / size;
    if (r > 1.0) discard;
    vec3 n = vec3(p / 0.78, 0.0);
    n.z = sqrt(max(1.0 - dot(n.xy, n.xy), 0.0));
    float light = 0.62 + 0.38 * max(dot(n, vec3(-0.35, 0.5, 0.79)), 0.0);
    vec3 ball = sqrt(vColour * vColour * light) + 0.25 * pow(max(dot(n, vec3(-0.25, 0.4, 0.88)), 0.0), 24.0);
    vec3 c = mix(ball, halo, smoothstep(0.78 - pixel, 0.78, r));
    gl_FragColor = vec4(c, 1.0 - smoothstep(1.0 - pixel, 1.0, r));
  }
`;

/** Arrows: an instance goes from `at` along `span`. Of the shape, x and y are across, in thicknesses; z says where along:
 * 0 the tail, 1 where the head begins, 2 the tip. */
export const arrowVertex = /* glsl */ `
  attribute vec3 at;
  attribute vec3 span;
  uniform float stretch;      // length of an arrow for a vector of length 1
  uniform float thickness;    // of an arrow, at most, in the mesh's unit
  varying float vLight;
  void main() {
    float size = length(span) * stretch;
    float thick = min(0.35 * size, thickness);
    float head = min(0.7 * size, 2.4 * thick);
    vec3 z = size > 0.0 ? normalize(span) : vec3(0.0, 0.0, 1.0);
    vec3 x = normalize(cross(abs(z.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), z));
    vec3 y = cross(z, x);
    // The head keeps its shape, the shaft takes up the length.
    float along = position.z < 0.5 ? 0.0 : position.z < 1.5 ? size - head : size;
    vec3 place = at + thick * (x * position.x + y * position.y) + z * along;
    vec3 n = normalMatrix * (x * normal.x + y * normal.y + z * normal.z);
    vLight = 0.6 + 0.4 * max(dot(normalize(n), vec3(-0.32, 0.46, 0.83)), 0.0);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(place, 1.0);
  }
`;

export const arrowFragment = /* glsl */ `
  uniform vec3 ink;
  varying float vLight;
  void main() {
    gl_FragColor = vec4(sqrt(ink * ink * vLight), 1.0);
  }
`;
