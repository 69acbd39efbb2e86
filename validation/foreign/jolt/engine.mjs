// Jolt's boxes, and its soft bodies with gas, which are the paper's model solved by XPBD (single precision).
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { seconds, serve, zeros } from "../protocol.mjs";

const installed = createRequire(pathToFileURL(process.argv[2] + "/")).resolve("jolt-physics");
const { default: init } = await import(pathToFileURL(installed));
const Jolt = await init();
const STILL = 0, MOVING = 1; // layers

const settings = new Jolt.JoltSettings();
settings.mMaxWorkerThreads = 0;
const pairs = new Jolt.ObjectLayerPairFilterTable(2), layers = new Jolt.BroadPhaseLayerInterfaceTable(2, 2);
pairs.EnableCollision(STILL, MOVING);
pairs.EnableCollision(MOVING, MOVING);
for (const layer of [STILL, MOVING]) layers.MapObjectToBroadPhaseLayer(layer, new Jolt.BroadPhaseLayer(layer));
settings.mObjectLayerPairFilter = pairs;
settings.mBroadPhaseLayerInterface = layers;
settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
const jolt = new Jolt.JoltInterface(settings), system = jolt.GetPhysicsSystem(), bodies = system.GetBodyInterface();
const usual = system.GetPhysicsSettings(), [VELOCITY_STEPS, POSITION_STEPS] = [usual.mNumVelocitySteps, usual.mNumPositionSteps];

function prepare(gravity, iterations) {
  system.SetGravity(new Jolt.Vec3(0, 0, -gravity));
  const chosen = system.GetPhysicsSettings();
  chosen.mMinVelocityForRestitution = 0;
  chosen.mNumVelocitySteps = Math.max(1, Math.round(iterations * VELOCITY_STEPS));
  chosen.mNumPositionSteps = Math.max(1, Math.round(iterations * POSITION_STEPS));
  system.SetPhysicsSettings(chosen);
}

function addBox(arrays, k, friction, restitution) {
  const row = (name, width) => Array.from(arrays[name].data.subarray(width * k, width * (k + 1)));
  const mass = arrays.mass.data[k], [w, x, y, z] = row("orientation", 4);
  const velocity = row("velocity", 3), spin = row("spin", 3);
  const held = !Number.isFinite(mass), moves = [...velocity, ...spin].some((one) => one !== 0);
  const kind = held ? (moves ? Jolt.EMotionType_Kinematic : Jolt.EMotionType_Static) : Jolt.EMotionType_Dynamic;
  const shape = new Jolt.BoxShape(new Jolt.Vec3(...row("size", 3).map((side) => side / 2)), 0);
  const made = new Jolt.BodyCreationSettings(
    shape, new Jolt.RVec3(...row("position", 3)), new Jolt.Quat(x, y, z, w), kind, held ? STILL : MOVING);
  Object.assign(made, { mAllowSleeping: false, mLinearDamping: 0, mAngularDamping: 0, mMaxLinearVelocity: 1e9 });
  Object.assign(made, { mMaxAngularVelocity: 1e9, mApplyGyroscopicForce: true, mFriction: friction });
  Object.assign(made, { mRestitution: restitution, mMotionQuality: Jolt.EMotionQuality_LinearCast });
  made.mLinearVelocity = new Jolt.Vec3(...velocity);
  made.mAngularVelocity = new Jolt.Vec3(...spin);
  if (!held) {
    made.mOverrideMassProperties = Jolt.EOverrideMassProperties_CalculateInertia;
    made.mMassPropertiesOverride.mMass = mass;
  }
  const body = bodies.CreateBody(made);
  bodies.AddBody(body.GetID(), Jolt.EActivation_Activate);
  Jolt.destroy(made);
  return body;
}

function boxRows(frames, count) {
  const three = () => zeros(frames, count, 3);
  return { position: three(), orientation: zeros(frames, count, 4), velocity: three(), spin: three() };
}

function tellBoxes({ position, orientation, velocity, spin }, made, frame) {
  made.forEach((body, k) => {
    const at = frame * made.length + k;
    const [p, q, v, s] = [body.GetPosition(), body.GetRotation(), body.GetLinearVelocity(), body.GetAngularVelocity()];
    position.data.set([p.GetX(), p.GetY(), p.GetZ()], 3 * at);
    orientation.data.set([q.GetW(), q.GetX(), q.GetY(), q.GetZ()], 4 * at);
    velocity.data.set([v.GetX(), v.GetY(), v.GetZ()], 3 * at);
    spin.data.set([s.GetX(), s.GetY(), s.GetZ()], 3 * at);
  });
}

function moveBoxes({ numbers: { step, steps, every, gravity, friction, restitution, iterations }, arrays }) {
  prepare(gravity, iterations);
  const count = arrays.mass.data.length, frames = Math.floor(steps / every);
  const made = Array.from({ length: count }, (_, k) => addBox(arrays, k, friction, restitution));
  const rows = boxRows(frames, count), begun = seconds();
  for (let frame = 0; frame < frames; frame++) {
    for (let n = 0; n < every; n++) jolt.Step(step, 1);
    tellBoxes(rows, made, frame);
  }
  const took = seconds() - begun;
  made.forEach((body) => (bodies.RemoveBody(body.GetID()), bodies.DestroyBody(body.GetID())));
  return { arrays: rows, seconds: took };
}

function addSoft({ numbers, arrays }, body) {
  const [first, end] = [arrays.particles.data[body], arrays.particles.data[body + 1]];
  const of = (name, width, start) => Array.from(arrays[name].data.subarray(width * start.data[body], width * start.data[body + 1]));
  const edges = of("edges", 2, arrays.edge_start), triangles = of("triangles", 3, arrays.triangle_start);
  const shared = new Jolt.SoftBodySharedSettings();
  for (let k = first; k < end; k++) {
    const one = new Jolt.SoftBodySharedSettingsVertex();
    one.mPosition = new Jolt.Float3(...arrays.vertices.data.subarray(3 * k, 3 * k + 3));
    one.mVelocity = new Jolt.Float3(...arrays.vertex_velocity.data.subarray(3 * k, 3 * k + 3));
    one.mInvMass = (end - first) / arrays.soft_mass.data[body];
    shared.mVertices.push_back(one);
  }
  for (let t = 0; t < triangles.length; t += 3)
    shared.AddFace(new Jolt.SoftBodySharedSettingsFace(...triangles.slice(t, t + 3), 0));
  for (let e = 0; e < edges.length; e += 2)
    shared.mEdgeConstraints.push_back(new Jolt.SoftBodySharedSettingsEdge(edges[e], edges[e + 1], 1 / arrays.stiffness.data[body]));
  shared.CalculateEdgeLengths();
  if (arrays.rest) // of the edges of the only body: as it lies, they pull
    for (let e = 0; e < edges.length / 2; e++) shared.mEdgeConstraints.at(e).mRestLength = arrays.rest.data[e];
  shared.Optimize();
  const made = new Jolt.SoftBodyCreationSettings(shared, new Jolt.RVec3(0, 0, 0), new Jolt.Quat(0, 0, 0, 1), MOVING);
  Object.assign(made, { mPressure: arrays.gas.data[body], mNumIterations: numbers.substeps, mLinearDamping: numbers.drag });
  Object.assign(made, { mFriction: numbers.friction, mRestitution: numbers.restitution, mAllowSleeping: false });
  Object.assign(made, { mUpdatePosition: false, mMaxLinearVelocity: 1e9 });
  const soft = bodies.CreateSoftBody(made);
  bodies.AddBody(soft.GetID(), Jolt.EActivation_Activate);
  return { soft, first, count: end - first };
}

function moveSoft(asked) {
  const { numbers: { step, steps, every, gravity, friction, restitution, iterations }, arrays } = asked;
  prepare(gravity, iterations);
  const number = arrays.mass.data.length, frames = Math.floor(steps / every), all = arrays.vertices.shape[0];
  const boxes = Array.from({ length: number }, (_, k) => addBox(arrays, k, friction, restitution));
  const softs = Array.from({ length: arrays.gas.data.length }, (_, body) => addSoft(asked, body));
  const vertices = zeros(frames, all, 3), vertex_velocity = zeros(frames, all, 3), rows = boxRows(frames, number);
  const begun = seconds();
  for (let frame = 0; frame < frames; frame++) {
    for (let n = 0; n < every; n++) jolt.Step(step, 1);
    tellBoxes(rows, boxes, frame);
    for (const { soft, first, count } of softs) {
      const now = Jolt.castObject(soft.GetMotionProperties(), Jolt.SoftBodyMotionProperties).GetVertices();
      for (let k = 0; k < count; k++) {
        const { mPosition: p, mVelocity: v } = now.at(k), at = 3 * (frame * all + first + k);
        vertices.data.set([p.GetX(), p.GetY(), p.GetZ()], at);
        vertex_velocity.data.set([v.GetX(), v.GetY(), v.GetZ()], at);
      }
    }
  }
  const took = seconds() - begun;
  for (const body of [...boxes, ...softs.map((one) => one.soft)]) {
    bodies.RemoveBody(body.GetID());
    bodies.DestroyBody(body.GetID());
  }
  return { arrays: { ...rows, vertices, vertex_velocity }, seconds: took };
}

serve({ move_boxes: moveBoxes, move_soft: moveSoft });
