// The surface as a picture that one can turn: depth is drawn downwards, as it is.

import { textureBytes } from './colours.js';
import { NOT_VALID } from './wire.js';

const SIDE = 128; // points along the longer side
const VERTEX = `#version 300 es
uniform highp sampler2D heights; uniform ivec2 size; uniform vec2 extent; uniform float lift; uniform mat4 camera;
out vec3 normal; out float depth; flat out int isValid;
float at(ivec2 p) { return texelFetch(heights, clamp(p, ivec2(0), size - 1), 0).r; }
void main() {
  ivec2 p = ivec2(gl_VertexID % size.x, gl_VertexID / size.x);
  vec2 pitch = extent / vec2(size - 1);
  depth = at(p);
  isValid = texelFetch(heights, p, 0).g > 0.5 ? 1 : 0;
  float gx = (at(p + ivec2(1, 0)) - at(p - ivec2(1, 0))) * lift / (2. * pitch.x);
  float gy = (at(p + ivec2(0, 1)) - at(p - ivec2(0, 1))) * lift / (2. * pitch.y);
  normal = normalize(vec3(gx, -gy, 1.));
  vec2 place = (vec2(p) / vec2(size - 1) - .5) * extent;
  gl_Position = camera * vec4(place.x, -place.y, -depth * lift, 1.);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D colours; uniform float largest; in vec3 normal; in float depth; flat in int isValid; out vec4 colour;
void main() {
  if (isValid == 0) discard;
  vec3 n = normalize(normal);
  float light = .45 + .55 * max(0., dot(n, normalize(vec3(-.5, .6, .8)))) + .25 * pow(max(0., n.z), 24.) - .2;
  vec3 base = texture(colours, vec2(.5 + .5 * clamp(depth / largest, -1., 1.), .5)).rgb;
  colour = vec4(mix(base, vec3(.75, .8, .9), .22) * light * 1.3, 1.);
}`;

export class Surface {
  /** Draws into a canvas; `failed` gets a sentence if the browser cannot. */
  constructor(canvas, failed) {
    this.canvas = canvas; this.azimuth = -.5; this.elevation = .85; this.distance = 1.8; this.isDirty = true;
    this.gl = canvas.getContext('webgl2', { antialias: true, alpha: true, preserveDrawingBuffer: true });
    if (!this.gl) { failed('This browser has no WebGL 2, so the surface cannot be drawn. The map beside it shows the same depth.'); return; }
    canvas.addEventListener('webglcontextlost', event => { event.preventDefault(); this.program = null; });
    canvas.addEventListener('webglcontextrestored', () => this.prepare());
    this.prepare(); this.listen();
  }

  prepare() {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind); gl.shaderSource(shader, source); gl.compileShader(shader); gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    this.program = gl.getProgramParameter(program, gl.LINK_STATUS) ? program : null;
    if (!this.program) return;
    this.place = name => gl.getUniformLocation(program, name);
    this.heights = this.texture(0); this.colours = this.texture(1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 512, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, textureBytes());
    gl.bindVertexArray(gl.createVertexArray());
    this.indices = gl.createBuffer(); this.size = null; this.isDirty = true;
  }

  texture(unit) {
    const gl = this.gl, texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit); gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
    return texture;
  }

  /** Takes new heights; `mmPerCell` relates them to the cells. */
  show(fields, largest, mmPerCell) {
    if (!this.program) return;
    const gl = this.gl, skip = Math.max(1, Math.ceil(Math.max(fields.columns, fields.rows) / SIDE));
    const columns = Math.floor(fields.columns / skip), rows = Math.floor(fields.rows / skip);
    const data = new Float32Array(2 * columns * rows);
    for (let row = 0; row < rows; row++) {
      for (let column = 0; column < columns; column++) {
        const steps = fields.values[row * skip * fields.columns + column * skip], at = 2 * (row * columns + column);
        if (steps !== NOT_VALID) { data[at] = steps * fields.step; data[at + 1] = 1; }
      }
    }
    gl.activeTexture(gl.TEXTURE0); gl.bindTexture(gl.TEXTURE_2D, this.heights);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32F, columns, rows, 0, gl.RG, gl.FLOAT, data);
    if (this.size?.[0] !== columns || this.size?.[1] !== rows) this.mesh(columns, rows);
    this.largest = largest; this.width = mmPerCell * skip * columns; this.height = mmPerCell * skip * rows; this.isDirty = true;
  }

  mesh(columns, rows) {
    const indices = new Uint32Array(6 * (columns - 1) * (rows - 1));
    let at = 0;
    for (let row = 0; row + 1 < rows; row++) {
      for (let column = 0; column + 1 < columns; column++) {
        const a = row * columns + column, b = a + columns;
        indices.set([a, b, a + 1, a + 1, b, b + 1], at); at += 6;
      }
    }
    this.gl.bindBuffer(this.gl.ELEMENT_ARRAY_BUFFER, this.indices);
    this.gl.bufferData(this.gl.ELEMENT_ARRAY_BUFFER, indices, this.gl.STATIC_DRAW);
    this.size = [columns, rows]; this.count = indices.length;
  }

  draw() {
    const scale = Math.min(window.devicePixelRatio || 1, 2), canvas = this.canvas;
    const width = Math.round(canvas.clientWidth * scale), height = Math.round(canvas.clientHeight * scale);
    if (!this.program || !this.size || width === 0) return;
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; this.isDirty = true; }
    if (!this.isDirty) return;
    this.isDirty = false;
    const gl = this.gl, unit = 1 / Math.max(this.width, this.height);
    gl.viewport(0, 0, width, height); gl.enable(gl.DEPTH_TEST); gl.clearColor(0, 0, 0, 0); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.program);
    gl.uniform1i(this.place('heights'), 0); gl.uniform1i(this.place('colours'), 1);
    gl.uniform2i(this.place('size'), ...this.size); gl.uniform2f(this.place('extent'), this.width * unit, this.height * unit);
    gl.uniform1f(this.place('lift'), Surface.LIFT * unit); gl.uniform1f(this.place('largest'), this.largest);
    gl.uniformMatrix4fv(this.place('camera'), false, this.matrix(width / height));
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_INT, 0);
  }

  /** Perspective · distance · elevation · azimuth, column by column. */
  matrix(aspect) {
    const [ca, sa, ce, se] = [Math.cos(this.azimuth), Math.sin(this.azimuth), Math.cos(this.elevation), Math.sin(this.elevation)];
    const focal = 2.2, near = .1, far = 10, a = (far + near) / (near - far), b = (2 * far * near) / (near - far);
    const fx = Math.min(focal, focal / aspect), fy = fx * aspect;
    const rows = [[ca, -sa, 0], [sa * se, ca * se, ce], [-sa * ce, -ca * ce, se]];
    const out = new Float32Array(16);
    for (let column = 0; column < 3; column++) {
      out[4 * column] = fx * rows[0][column]; out[4 * column + 1] = fy * rows[1][column];
      out[4 * column + 2] = a * rows[2][column]; out[4 * column + 3] = -rows[2][column];
    }
    out[14] = -a * this.distance + b; out[15] = this.distance;
    return out;
  }

  turn(azimuth, elevation, closer) {
    this.azimuth += azimuth; this.elevation = Math.min(1.55, Math.max(.1, this.elevation + elevation));
    this.distance = Math.min(5, Math.max(.9, this.distance * closer)); this.isDirty = true;
  }

  listen() {
    const canvas = this.canvas, keys = {
      ArrowLeft: [.1, 0, 1], ArrowRight: [-.1, 0, 1], ArrowUp: [0, .1, 1], ArrowDown: [0, -.1, 1], '+': [0, 0, .9], '-': [0, 0, 1.1],
    };
    const pointers = new Map();
    let spread = 0;
    canvas.addEventListener('pointerdown', event => { canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, event); spread = 0; });
    canvas.addEventListener('pointermove', event => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      pointers.set(event.pointerId, event);
      if (pointers.size === 1) { this.turn((event.clientX - before.clientX) * .01, (event.clientY - before.clientY) * .01, 1); return; }
      const [p, q] = [...pointers.values()], now = Math.hypot(p.clientX - q.clientX, p.clientY - q.clientY);
      if (spread > 0 && now > 0) this.turn(0, 0, spread / now);
      spread = now;
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, event => { pointers.delete(event.pointerId); spread = 0; });
    canvas.addEventListener('wheel', event => { event.preventDefault(); this.turn(0, 0, Math.exp(event.deltaY * .001)); }, { passive: false });
    canvas.addEventListener('keydown', event => { const turn = keys[event.key]; if (turn) { event.preventDefault(); this.turn(...turn); } });
  }
}
/** Depth is drawn this many times larger than lengths along the surface. */
Surface.LIFT = 2;
