// Makes players of the scenes: three.js draws what moved, from wherever one looks. Without it the films loop as they are.
(() => {
  const scenes = [...document.querySelectorAll("details.scene")];
  let printing = false;
  addEventListener("beforeprint", () => { printing = true; });
  addEventListener("afterprint", () => { printing = false; });

  const held = (node) => node.content.textContent;
  const inflated = async (text) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };

  let library;
  const three = () => library ??= (async () => {
    const script = document.createElement("script");
    script.textContent = new TextDecoder().decode(await inflated(held(document.getElementById("three"))));
    document.head.append(script);
    return window.THREE;
  })();

  // Of each frame x of all vertices, then y, then z, in metres; reports/motions.py says how they are coded.
  const placesOf = async (motion) => {
    const bytes = await inflated(motion.places), count = bytes.length / 2;
    const n = motion.vertices.reduce((sum, one) => sum + one, 0), size = 3 * n;
    const whole = new Int32Array(count), metres = new Float32Array(count);
    for (let i = 0; i < count; i += 1) {
      const code = bytes[i] | (bytes[count + i] << 8);
      const before = i < size ? 0 : whole[i - size], earlier = i < 2 * size ? before : whole[i - 2 * size];
      whole[i] = 2 * before - earlier + ((code >>> 1) ^ -(code & 1));
      metres[i] = motion.low[Math.floor((i % size) / n)] + motion.part * whole[i];
    }
    return { metres, n };
  };

  const meshesOf = async (THREE, motion) => {
    const triangles = new Uint16Array((await inflated(motion.triangles)).buffer);
    const along = new Int8Array((await inflated(motion.along)).buffer);
    let vertex = 0, face = 0;
    return motion.vertices.map((n, k) => {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * n), 3));
      const across = Float32Array.from({ length: 2 * n }, (_, i) => 0.5 + along[vertex + (i >> 1)] / 256);
      geometry.setAttribute("uv", new THREE.BufferAttribute(across, 2));
      geometry.setIndex(new THREE.BufferAttribute(triangles.slice(3 * face, 3 * (face + motion.faces[k])), 1));
      const texels = motion.colours[k].flatMap((colour) => [...colour.map((one) => Math.round(255 * one)), 255]);
      const map = new THREE.DataTexture(new Uint8Array(texels), 2, 1);
      map.needsUpdate = true;
      const look = { map, shininess: 12, flatShading: !motion.smooth[k] };
      if (motion.clear[k]) Object.assign(look, { transparent: true, opacity: 0.45, depthWrite: false });
      const mesh = new THREE.Mesh(geometry, new THREE.MeshPhongMaterial(look));
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.frustumCulled = false;
      mesh.userData.first = vertex;
      vertex += n;
      face += motion.faces[k];
      return mesh;
    });
  };

  const stage = (THREE, motion, meshes, low, high) => {
    const scene = new THREE.Scene();
    scene.background = new THREE.Color(0xedf2fa);
    const middle = low.map((one, k) => 0.5 * (one + high[k])), radius = 0.5 * Math.hypot(...low.map((one, k) => high[k] - one));
    const sky = new THREE.HemisphereLight(0xffffff, 0x9aa3ad, 0.7);
    sky.position.set(0, 0, 1);
    scene.add(sky);
    const sun = new THREE.DirectionalLight(0xffffff, 0.45);
    sun.position.set(middle[0] - 0.9 * radius, middle[1] - 0.8 * radius, middle[2] + 2 * radius);
    sun.target.position.set(...middle);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    Object.assign(sun.shadow, { bias: -0.0005, normalBias: 0.02 });
    Object.assign(sun.shadow.camera, { left: -radius, right: radius, top: radius, bottom: -radius, near: 0.1, far: 6 * radius });
    scene.add(sun, sun.target, ...meshes);
    if (motion.ground !== null) {
      const texels = new Uint8Array([209, 214, 219, 255, 189, 194, 201, 255, 189, 194, 201, 255, 209, 214, 219, 255]);
      const map = new THREE.DataTexture(texels, 2, 2);
      map.wrapS = map.wrapT = THREE.RepeatWrapping;
      const side = 2 * Math.ceil(4 * radius);
      map.repeat.set(side / 2, side / 2);
      map.needsUpdate = true;
      const ground = new THREE.Mesh(new THREE.PlaneGeometry(side, side), new THREE.MeshPhongMaterial({ map, shininess: 0 }));
      ground.position.set(Math.round(middle[0]), Math.round(middle[1]), motion.ground);
      ground.receiveShadow = true;
      scene.add(ground);
    }
    return scene;
  };

  const build = (tag, values, ...children) => {
    const node = Object.assign(document.createElement(tag), values);
    node.append(...children);
    return node;
  };

  const start = async (details) => {
    const player = details.querySelector(".player");
    const THREE = await three();
    const motion = JSON.parse(held(details.querySelector("template")));
    const [{ metres, n }, meshes] = [await placesOf(motion), await meshesOf(THREE, motion)];
    const low = motion.low, high = [0, 1, 2].map((k) => {
      let most = -Infinity;
      for (let i = 0; i < metres.length; i += 1) if (Math.floor((i % (3 * n)) / n) === k && metres[i] > most) most = metres[i];
      return most;
    });
    const renderer = new THREE.WebGLRenderer({ antialias: true });
    renderer.shadowMap.enabled = true;
    renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    const scene = stage(THREE, motion, meshes, low, high);
    const camera = new THREE.PerspectiveCamera(motion.view, 4 / 3, 0.05, 200);
    camera.up.set(0, 0, 1);
    camera.position.set(...motion.camera[0][0]);
    const controls = new THREE.TrackballControls(camera, renderer.domElement);
    Object.assign(controls, { rotateSpeed: 2.5, staticMoving: true, noZoom: true });
    controls.target.set(...motion.camera[0][1]);
    controls.target0.copy(controls.target);

    const last = motion.time.length - 1, end = motion.time[last];
    const say = (label, text) => build("button", { type: "button", ariaLabel: label, title: label, textContent: text });
    const play = say("Play or pause", "▶"), back = say("One frame back", "◀|"), on = say("One frame on", "|▶");
    const again = say("Look from where the film does", "⟲");
    const slider = build("input", { type: "range", min: 0, max: end, step: "any", value: 0, ariaLabel: "Time" });
    const speed = build("select", { ariaLabel: "Speed" }, ...[1, 0.5, 0.25, 0.1].map((one) => build("option", { value: one, textContent: `${one} ×` })));
    const clock = build("output", {});
    const canvas = build("div", { className: "canvas" }, renderer.domElement);
    renderer.domElement.setAttribute("aria-label", "The scene; drag to turn it");
    player.prepend(canvas, build("div", { className: "controls" }, back, play, on, slider, speed, again, clock),
      build("p", { className: "meta", textContent: "Drag to turn, with the right button to move; the wheel zooms once you have dragged." }));
    const marks = [...player.querySelectorAll(".curve")];
    let time = 0, running = false, seen = -1, eye = motion.camera[0][1], lastTick = 0;

    const shape = () => {
      const at = motion.time.findIndex((one) => one >= time), k = Math.max(1, at < 0 ? last : at);
      const part = Math.min(1, Math.max(0, (time - motion.time[k - 1]) / (motion.time[k] - motion.time[k - 1])));
      for (const mesh of meshes) {
        const { position } = mesh.geometry.attributes, { first } = mesh.userData;
        for (let axis = 0; axis < 3; axis += 1) {
          const from = 3 * n * (k - 1) + n * axis + first, to = from + 3 * n;
          for (let i = 0; i < position.count; i += 1) {
            position.array[3 * i + axis] = metres[from + i] + part * (metres[to + i] - metres[from + i]);
          }
        }
        position.needsUpdate = true;
        if (!mesh.material.flatShading) mesh.geometry.computeVertexNormals();
      }
      const target = [0, 1, 2].map((axis) => motion.camera[k - 1][1][axis] + part * (motion.camera[k][1][axis] - motion.camera[k - 1][1][axis]));
      const moved = new THREE.Vector3(...target.map((one, axis) => one - eye[axis]));
      for (const each of [camera.position, controls.target, controls.target0, controls.position0]) each.add(moved);
      eye = target;
      slider.value = time;
      clock.textContent = `${time.toFixed(2)} s of ${end.toFixed(2)} s`;
      const near = part < 0.5 ? k - 1 : k;
      for (const mark of marks) {
        mark.querySelector(".now").setAttribute("x1", 100 * time / end);
        mark.querySelector(".now").setAttribute("x2", 100 * time / end);
        mark.querySelector("output").textContent = `${motion.measured[mark.dataset.name][near]} ${mark.dataset.unit}`;
      }
    };

    const size = () => {
      const width = canvas.clientWidth, height = canvas.clientHeight;
      if (!width) return;
      renderer.setSize(width, height);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      controls.handleResize();
      seen = -1;
    };
    new ResizeObserver(size).observe(canvas);
    controls.addEventListener("change", () => { seen = -1; });

    const tick = (now) => {
      if (!details.open) { running = false; play.textContent = "▶"; return; }
      if (running) {
        time += Math.min(0.1, (now - lastTick) / 1000) * Number(speed.value);
        if (time >= end) { time = end; run(false); }
      }
      lastTick = now;
      controls.update();
      if (time !== seen) {
        shape();
        controls.update();
        renderer.render(scene, camera);
        seen = time;
      }
      requestAnimationFrame(tick);
    };
    const run = (whether) => {
      running = whether;
      play.textContent = running ? "❚❚" : "▶";
      if (running && time >= end) time = 0;
    };
    const to = (frame) => { run(false); time = motion.time[Math.min(last, Math.max(0, frame))]; };
    const nearest = () => motion.time.reduce((best, one, k) => (Math.abs(one - time) < Math.abs(motion.time[best] - time) ? k : best), 0);
    play.addEventListener("click", () => run(!running));
    back.addEventListener("click", () => to(nearest() - 1));
    on.addEventListener("click", () => to(nearest() + 1));
    again.addEventListener("click", () => { controls.reset(); seen = -1; });
    slider.addEventListener("input", () => { run(false); time = Number(slider.value); });
    for (const mark of marks) {
      mark.querySelector("svg").addEventListener("click", (event) => {
        const box = mark.querySelector("svg").getBoundingClientRect();
        run(false);
        time = end * Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
      });
    }
    renderer.domElement.addEventListener("pointerdown", () => { controls.handleResize(); controls.noZoom = false; });
    renderer.domElement.addEventListener("pointerleave", () => { controls.noZoom = true; });
    details.addEventListener("toggle", () => { if (details.open) requestAnimationFrame(tick); });
    details.classList.add("playing");
    size();
    run(!matchMedia("(prefers-reduced-motion: reduce)").matches);
    requestAnimationFrame((now) => { lastTick = now; tick(now); });
    player.dataset.ready = "yes";
  };

  for (const details of scenes) {
    let begun = false;
    details.addEventListener("toggle", () => {
      if (!details.open || begun || printing || !document.getElementById("three")) return;
      begun = true;
      start(details).catch((error) => {
        details.querySelector(".player").prepend(build("p", { className: "why", textContent: `The scene cannot be turned in this browser (${error.message}).` }));
      });
    });
  }
})();
