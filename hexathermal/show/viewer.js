"use strict";
// Draws the frames of the page: poses, colours, trail and ellipsoid follow the slider; meshcat renders.
(() => {
  const at = (id) => document.getElementById(id);
  const data = JSON.parse(at("data").textContent);
  const count = data.labels.length, um = 1e-6, perSecond = 12;
  let viewer = null, now = data.start, way = 0, factor = data.magnify, playing = false, last = 0;

  // --- small algebra: vectors, quaternions [x, y, z, w], columns of rotations
  const add = (a, b) => a.map((v, i) => v + b[i]), times = (a, s) => a.map((v) => v * s);
  const less = (a, b) => a.map((v, i) => v - b[i]), size = (a) => Math.hypot(...a);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const mix = (a, b, t) => (a === null || b === null ? a : a + (b - a) * t);
  const mixed = (a, b, t) => a.map((v, i) => mix(v, b[i], t));
  const unit = (q) => times(q, 1 / size(q));
  const product = (a, b) => [
    a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
    a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]];
  const turned = (w) => { // rotation vector
    const angle = size(w), s = angle > 1e-12 ? Math.sin(angle / 2) / angle : 0.5;
    return [...times(w, s), Math.cos(angle / 2)];
  };
  const rotate = (q, v) => {
    const t = times(cross(q.slice(0, 3), v), 2);
    return add(v, add(times(t, q[3]), cross(q.slice(0, 3), t)));
  };
  const axes = (q) => [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((v) => rotate(q, v));
  const matrix = (columns, p) => [...columns.flatMap((c) => [...c, 0]), ...p, 1];
  const along = (from, to) => { // z from one joint to the other
    const z = times(less(to, from), 1 / size(less(to, from)));
    const e = [0, 0, 0];
    e[z.map(Math.abs).indexOf(Math.min(...z.map(Math.abs)))] = 1;
    const x = unit(cross(e, z));
    return [x, cross(z, x), z];
  };

  // --- one moment of the course, between frames where the machine moves smoothly
  function moment(t) {
    const i = Math.min(Math.floor(t), count - 1), j = Math.min(i + 1, count - 1);
    const s = data.smooth && data.group[i] === data.group[j] ? t - i : 0;
    const a = data.ideal[i], b = data.ideal[j];
    const sign = a.slice(3).reduce((sum, v, k) => sum + v * b[3 + k], 0) < 0 ? -1 : 1;
    return {
      frame: i, p: mixed(a.slice(0, 3), b.slice(0, 3), s), q: unit(mixed(a.slice(3), times(b.slice(3), sign), s)),
      error: mixed(data.errors[way][i], data.errors[way][j], s), heat: mixed(data.legs_degC[i], data.legs_degC[j], s),
      centre: mixed(data.centres[way][i], data.centres[way][j], s),
      region: data.regions[way][s < 0.5 ? i : j],
    };
  }

  function platform(m, scale) { // where the platform is drawn, its drift `scale` times larger
    const q = product(turned(times(m.error.slice(3), um * scale)), m.q);
    const wanted = add(m.p, rotate(m.q, data.tool)), tool = add(wanted, times(m.error.slice(0, 3), um * scale));
    return { q, tool, wanted, p: less(tool, rotate(q, data.tool)) };
  }

  const colour = (degC) => {
    const [low, high] = data.range_degC, p = data.palette;
    const x = Math.min(1, Math.max(0, (degC - low) / (high - low))) * (p.length - 1);
    const i = Math.min(Math.floor(x), p.length - 2);
    return mixed(p[i], p[i + 1], x - i);
  };
  const css = (rgb) => `rgb(${rgb.map((v) => Math.round(255 * v)).join(",")})`;

  // --- meshcat
  const centre = times(add(...data.bounds), 0.5), scale = 2 / size(less(data.bounds[1], data.bounds[0]));
  const middle = times(data.platform_joints.reduce(add), 1 / 6);
  const path = (name) => ["meshcat", "machine", name];
  const thing = (name) => viewer.scene_tree.find([...path(name), "<object>"]).object;
  const put = (name, columns, p) => viewer.set_transform(path(name), matrix(columns, p));
  const show = (name, visible) => { viewer.scene_tree.find(path(name)).object.visible = visible; };
  const still = [[1, 0, 0], [0, 1, 0], [0, 0, 1]], dot = 0.012 / scale;
  const ball = still.map((c) => times(c, dot));

  function line(name, points) {
    const geometry = thing(name).geometry, where = geometry.attributes.position;
    points.forEach((p, k) => where.array.set(p, 3 * k));
    where.needsUpdate = true;
    geometry.setDrawRange(0, points.length);
  }

  function start() {
    const pane = at("pane");
    viewer = new MeshCat.Viewer(pane, false);
    viewer.gui.domElement.remove();
    const sized = viewer.set_3d_pane_size;
    viewer.set_3d_pane_size = () => sized.call(viewer, pane.clientWidth, pane.clientHeight);
    new ResizeObserver(() => viewer.set_3d_pane_size()).observe(pane);
    for (const text of JSON.parse(at("scene").textContent)) {
      viewer.handle_command_bytearray(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)));
    }
    for (const name of ["trail", "drift", "arm", "wanted_arm", "trail_dots"]) thing(name).frustumCulled = false;
    for (const name of ["trail_dots"]) Object.assign(thing(name).material, { vertexColors: false, depthTest: false });
    ["ellipsoid", "trail", "trail_dots", "drift", "wanted_tool", "tool"].forEach((name, k) => { thing(name).renderOrder = 10 + k; });
    viewer.set_transform(["meshcat", "machine"], matrix(still.map((c) => times(c, scale)), times(centre, -scale)));
    viewer.set_property(["Axes"], "visible", false);
    viewer.set_property(["Grid"], "visible", false);
    viewer.camera.fov = 32;
    viewer.camera.position.set(2.6, 1.2, 2.2);
    viewer.controls.target.set(0, 0, 0);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const paint = () => {
      viewer.scene_tree.find(["Background"]).object.top_color = dark.matches ? [38, 46, 56] : [232, 238, 245];
      viewer.scene_tree.find(["Background"]).object.bottom_color = dark.matches ? [18, 22, 27] : [255, 255, 255];
      viewer.show_background();
      const wanted = Object.keys(data.parts).filter((name) => data.parts[name].frame === "platform");
      for (const name of [...wanted.map((one) => `ghost_${one}`), "wanted_tool", "wanted_arm"]) {
        thing(name).material.color.setHex(dark.matches ? 0x9cc8f0 : 0x2f6fb0);
      }
    };
    paint();
    dark.addEventListener("change", paint);
    viewer.set_3d_pane_size();
    requestAnimationFrame(tick);
  }

  function draw() {
    const m = moment(now), body = platform(m, factor), turns = axes(body.q);
    words(m);
    if (!viewer) return;
    for (const [name, part] of Object.entries(data.parts)) {
      if (part.frame === "platform") {
        put(name, turns, body.p);
        put(`ghost_${name}`, axes(m.q), m.p);
        show(`ghost_${name}`, at("show-ideal").checked);
      } else if (part.frame !== "base") {
        const leg = Number(part.frame[3]) - 1, low = data.base_joints[leg];
        const high = add(body.p, rotate(body.q, data.platform_joints[leg]));
        put(name, along(low, high), part.frame.endsWith("body") ? low : high);
        const rgb = m.heat[leg] === null ? part.colour : colour(m.heat[leg]), material = thing(name).material;
        material.color.setRGB(...times(rgb, 0.7));
        material.emissive.setRGB(...times(rgb, 0.2));
      }
    }
    put("tool", ball, body.tool);
    put("wanted_tool", ball, body.wanted);
    line("drift", [body.wanted, body.tool]);
    line("arm", [add(body.p, rotate(body.q, middle)), body.tool]);
    line("wanted_arm", [add(m.p, rotate(m.q, middle)), body.wanted]);
    for (const name of ["wanted_tool", "wanted_arm", "drift"]) show(name, at("show-ideal").checked);
    const trail = [];
    for (let k = 0; k <= m.frame; k++) {
      if (data.group[k] === data.group[m.frame]) {
        trail.push(add(body.wanted, times(data.errors[way][k].slice(0, 3), um * factor)));
      }
    }
    trail.push(body.tool);
    trail.splice(0, Math.max(0, trail.length - count));
    for (const name of ["trail", "trail_dots"]) {
      line(name, trail);
      show(name, at("show-trail").checked);
    }
    const known = m.region[0] !== null && m.centre[0] !== null;
    show("ellipsoid", known && at("show-ellipsoid").checked);
    if (known) {
      const columns = [0, 3, 6].map((k) => times(m.region.slice(k, k + 3), um * factor));
      put("ellipsoid", columns, add(body.wanted, times(m.centre, um * factor)));
    }
    viewer.set_dirty();
  }

  const told = (value, name) => `${value < 10 ? value.toFixed(2) : value.toFixed(1)} ${name}`;

  function words(m) {
    at("time").value = m.frame;
    at("time").setAttribute("aria-valuetext", data.labels[m.frame]);
    at("label").textContent = data.labels[m.frame];
    if (!data.known) return;
    at("shift").textContent = told(size(m.error.slice(0, 3)), "µm");
    at("turn").textContent = told(size(m.error.slice(3)), "µrad");
    at("stated").textContent = `drift drawn ${factor.toLocaleString("en").replaceAll(",", "\u202f")} times larger`;
    at("factor").textContent = `1 µm is drawn as ${told(factor / 1e3, "mm")}, 1 µrad as ${told(factor / 1e3, "mrad")}.`;
    if (!data.range_degC) return;
    m.heat.forEach((degC, leg) => {
      const item = at("legs").children[leg];
      item.firstChild.style.background = degC === null ? "none" : css(colour(degC));
      item.lastChild.textContent = `${leg + 1}: ${degC === null ? "–" : degC.toFixed(1)}`;
    });
  }

  function legend() {
    [0, 1].forEach((k) => { at(`words-${k}`).textContent = data.words[k]; });
    at("magnify").value = factor;
    if (!data.known) {
      at("magnify").closest("section").hidden = at("shift").closest("dl").hidden = true;
      document.querySelector("input[name=way]").closest("fieldset").hidden = at("stated").hidden = true;
      ["show-trail", "show-ellipsoid"].forEach((id) => { at(id).closest("label").hidden = true; });
    }
    if (!data.range_degC) {
      at("scale").closest("section").replaceChildren("No temperatures: the legs have the colour of metal.");
      return;
    }
    const [low, high] = data.range_degC;
    at("scale").style.background = `linear-gradient(90deg,${data.palette.map(css).join(",")})`;
    at("scale").setAttribute("aria-label", `colours from ${low.toFixed(1)} °C, dark, to ${high.toFixed(1)} °C, light`);
    for (let k = 0; k < 5; k++) {
      const tick = document.createElement("span");
      tick.textContent = (low + ((high - low) * k) / 4).toFixed(1);
      at("ticks").append(tick);
    }
    for (let leg = 0; leg < 6; leg++) {
      const item = document.createElement("li"), mark = document.createElement("span");
      mark.className = "dot";
      item.append(mark, document.createElement("span"));
      at("legs").append(item);
    }
  }

  function play(on) {
    playing = on;
    at("play").textContent = on ? "Pause" : "Play";
    if (on && now >= count - 1) now = 0;
  }

  function tick(time) {
    requestAnimationFrame(tick);
    if (playing) {
      now = Math.min(count - 1, now + Math.min(0.5, (time - last) / 1e3) * perSecond);
      if (now >= count - 1) play(false);
      draw();
    }
    last = time;
    if (viewer.needs_render) viewer.render();
  }

  at("play").addEventListener("click", () => play(!playing));
  at("time").addEventListener("input", () => { play(false); now = Number(at("time").value); draw(); });
  document.querySelectorAll("input[name=way]").forEach((one) => one.addEventListener("change", () => {
    way = Number(one.value);
    draw();
  }));
  at("magnify").addEventListener("input", () => {
    const value = Number(at("magnify").value);
    if (value >= 1 && value <= 1e7) { factor = value; draw(); }
  });
  for (const name of ["show-ideal", "show-trail", "show-ellipsoid"]) at(name).addEventListener("change", draw);
  legend();
  try {
    start();
  } catch (error) {
    viewer = null;
    at("pane").hidden = true;
    at("no-drawing").hidden = false;
    at("no-drawing").textContent = `This browser cannot draw in three dimensions (WebGL): ${error.message}`;
  }
  draw();
  window.viewerState = () => ({
    frame: moment(now).frame, way, factor, playing, ...platform(moment(now), factor), error: moment(now).error,
    colours: viewer ? [1, 2, 3, 4, 5, 6].map((leg) => thing(`leg${leg}_body`).material.emissive.toArray()) : [],
    drawn: viewer ? viewer.scene_tree.find(path("platform")).object.position.toArray() : null,
  });
})();
