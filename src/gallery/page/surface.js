// The sample's surface from its labels, seen by the left camera, to turn with the mouse: plain WebGL2.

const SHADERS = [
  `#version 300 es
  in vec3 place; in vec2 texel; uniform mat4 clip_from_world; uniform float rise; out vec2 at;
  void main() { at = texel; gl_Position = clip_from_world * vec4(place.xy, place.z * rise, 1.0); }`,
  `#version 300 es
  precision highp float; in vec2 at; uniform sampler2D image; out vec4 colour;
  void main() { colour = vec4(texture(image, at).rgb, 1.0); }`,
];

class Surface {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", { antialias: true });
    this.rise = 1;
    this.reset();
    if (this.gl) this.program = this.link();
  }

  reset() {
    Object.assign(this, { yaw: -0.5, pitch: 0.75, distance: 1.5, aside: 0, ahead: 0 });
  }

  link() {
    const gl = this.gl, program = gl.createProgram();
    [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].forEach((kind, i) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, SHADERS[i]);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    });
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    return program;
  }

  /** Takes a sample. A triangle is left out where it would span more than a pixel of disparity a pixel: the left view does
      not see what lies there. */
  load(sample, { disparity, validity }, image) {
    const { columns, rows, every } = sample, count = columns * rows;
    const places = new Float32Array(count * 3), texels = new Float32Array(count * 2);
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const points = new Float64Array(count * 3);
    for (let i = 0; i < count; i++) {
      const column = i % columns, row = (i - column) / columns;
      texels.set([(column + 0.5) / columns, (row + 0.5) / rows], 2 * i);
      if (!validity[i]) continue;
      const point = worldPoint(sample, fullPixel(sample, column), fullPixel(sample, row), disparity[i]);
      points.set(point, 3 * i);
      point.forEach((x, k) => { low[k] = Math.min(low[k], x); high[k] = Math.max(high[k], x); });
    }
    const middle = low.map((x, k) => (x + high[k]) / 2);
    this.size = Math.max(high[0] - low[0], high[1] - low[1], 1);
    for (let i = 0; i < 3 * count; i++) places[i] = (points[i] - middle[i % 3]) / this.size;
    const triangles = new Uint32Array(6 * (columns - 1) * (rows - 1));
    let used = 0;
    const add = (a, b, c) => {
      const [x, y, z] = [disparity[a], disparity[b], disparity[c]];
      if (Math.max(x, y, z) - Math.min(x, y, z) <= every) triangles.set([a, b, c], used), (used += 3);
    };
    for (let row = 0; row + 1 < rows; row++) {
      for (let column = 0; column + 1 < columns; column++) {
        const i = row * columns + column;
        add(i, i + columns, i + 1);
        add(i + 1, i + columns, i + columns + 1);
      }
    }
    this.triangles = used;
    if (!this.gl) return;
    const gl = this.gl;
    const buffer = (kind, data) => {
      const made = gl.createBuffer();
      gl.bindBuffer(kind, made);
      gl.bufferData(kind, data, gl.STATIC_DRAW);
      return made;
    };
    (this.held ?? []).forEach((b) => gl.deleteBuffer(b));
    gl.deleteTexture(this.texture ?? null);
    this.held = [buffer(gl.ARRAY_BUFFER, places), buffer(gl.ARRAY_BUFFER, texels), buffer(gl.ELEMENT_ARRAY_BUFFER, triangles.subarray(0, used))];
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, gl.RGB, gl.UNSIGNED_BYTE, image);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T].forEach((wrap) => gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE));
  }

  /** Clip from world, columns first: orbit around the middle, then a view of 40 degrees. */
  matrix() {
    const [sy, cy, sp, cp] = [Math.sin(this.yaw), Math.cos(this.yaw), Math.sin(this.pitch), Math.cos(this.pitch)];
    const right = [cy, sy, 0], up = [-sy * sp, cy * sp, cp], back = [sy * cp, -cy * cp, sp];
    const focal = 1 / Math.tan((20 * Math.PI) / 180), aspect = this.canvas.width / Math.max(1, this.canvas.height);
    const near = this.distance / 50, far = this.distance + 6;
    const rows = [
      [...right.map((x) => (x * focal) / aspect), (-this.aside * focal) / aspect],
      [...up.map((x) => x * focal), -this.ahead * focal],
    ];
    const a = (far + near) / (near - far), b = (2 * far * near) / (near - far);
    rows.push([...back.map((x) => x * a), -this.distance * a + b], [...back.map((x) => -x), this.distance]);
    return new Float32Array([0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column])));
  }

  draw() {
    const gl = this.gl;
    if (!gl || !this.held) return;
    const scale = devicePixelRatio;
    this.canvas.width = Math.round(this.canvas.clientWidth * scale);
    this.canvas.height = Math.round(this.canvas.clientHeight * scale);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0.04, 0.05, 0.06, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(this.program);
    [["place", 3], ["texel", 2]].forEach(([name, size], i) => {
      const at = gl.getAttribLocation(this.program, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.held[i]);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.held[2]);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.program, "clip_from_world"), false, this.matrix());
    gl.uniform1f(gl.getUniformLocation(this.program, "rise"), this.rise);
    gl.drawElements(gl.TRIANGLES, this.triangles, gl.UNSIGNED_INT, 0);
  }

  turn(dx, dy) {
    this.yaw -= dx;
    this.pitch = Math.min(1.57, Math.max(-0.2, this.pitch + dy));
    this.draw();
  }

  move(dx, dy) {
    this.aside -= dx * this.distance;
    this.ahead += dy * this.distance;
    this.draw();
  }

  zoom(factor) {
    this.distance = Math.min(6, Math.max(0.05, this.distance * factor));
    this.draw();
  }
}
