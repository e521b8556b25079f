// Jolt's soft body, compiled to WebAssembly: node jolt_cloth.mjs JOB.json (the job: see harness.py).
// settings: iterations (Jolt takes that many substeps of one constraint pass each), compliance [m/N] of the edges,
// attachments (1: each particle is also tied to the nearest pin at its rest distance, Jolt's long range attachments).
// The edges are added by hand: CreateConstraints() would add both diagonals with one compliance.
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';

const FPS = 60;
const FORESIGHT = 5; // as in harness.py
const job = JSON.parse(fs.readFileSync(process.argv[2], 'utf8'));
const require = createRequire(path.join(job.environment, 'here.js'));
const Jolt = await (await import(pathToFileURL(require.resolve('jolt-physics')))).default();

function world() {
  const settings = new Jolt.JoltSettings();
  const layers = new Jolt.ObjectLayerPairFilterTable(1);
  const broad = new Jolt.BroadPhaseLayerInterfaceTable(1, 1);
  broad.MapObjectToBroadPhaseLayer(0, new Jolt.BroadPhaseLayer(0));
  settings.mObjectLayerPairFilter = layers;
  settings.mBroadPhaseLayerInterface = broad;
  settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(broad, 1, layers, 1);
  const jolt = new Jolt.JoltInterface(settings);
  jolt.GetPhysicsSystem().SetGravity(new Jolt.Vec3(0, 0, -9.81));
  return jolt;
}

function nearestPin(position) {
  const distances = job.pins.map((pin) => Math.hypot(...position.map((x, axis) => x - job.positions[pin][axis])));
  const distance = Math.min(...distances);
  return { pin: job.pins[distances.indexOf(distance)], distance };
}

function sheet() {
  const { compliance, attachments } = job.settings;
  const pinned = new Set(job.pins);
  const shared = new Jolt.SoftBodySharedSettings();
  const vertex = new Jolt.SoftBodySharedSettingsVertex();
  job.positions.forEach((position, index) => {
    vertex.mPosition = new Jolt.Float3(...position);
    vertex.mInvMass = pinned.has(index) ? 0 : 1 / job.masses[index];
    shared.mVertices.push_back(vertex);
  });
  for (const corners of job.triangles) shared.AddFace(new Jolt.SoftBodySharedSettingsFace(...corners, 0));
  for (const ends of job.edges) {
    shared.mEdgeConstraints.push_back(new Jolt.SoftBodySharedSettingsEdge(...ends, compliance));
  }
  if (attachments) {
    job.positions.forEach((position, index) => {
      if (pinned.has(index)) return;
      const { pin, distance } = nearestPin(position);
      shared.mLRAConstraints.push_back(new Jolt.SoftBodySharedSettingsLRA(pin, index, distance));
    });
  }
  shared.CalculateEdgeLengths();
  shared.Optimize();
  return shared;
}

function addBody(jolt) {
  const creation = new Jolt.SoftBodyCreationSettings(sheet(), new Jolt.RVec3(0, 0, 0), new Jolt.Quat(0, 0, 0, 1), 0);
  creation.mNumIterations = job.settings.iterations;
  creation.mLinearDamping = 0;
  creation.mUpdatePosition = false;
  creation.mAllowSleeping = false;
  creation.mVertexRadius = 0;
  const bodies = jolt.GetPhysicsSystem().GetBodyInterface();
  const body = bodies.CreateSoftBody(creation);
  bodies.AddBody(body.GetID(), Jolt.EActivation_Activate);
  return body;
}

// Positions of all vertices, read from the heap: they are relative to the body's centre.
function reader(body) {
  const motion = Jolt.castObject(body.GetMotionProperties(), Jolt.SoftBodyMotionProperties);
  const offset = Jolt.SoftBodyVertexTraits.prototype.mPositionOffset;
  const frame = new Float32Array(3 * job.positions.length);
  return () => {
    const vertices = motion.GetVertices();
    const at = body.GetCenterOfMassPosition();
    const centre = [at.GetX(), at.GetY(), at.GetZ()];
    for (let index = 0; index < job.positions.length; index++) {
      const place = (Jolt.getPointer(vertices.at(index)) + offset) / 4;
      for (let axis = 0; axis < 3; axis++) frame[3 * index + axis] = Jolt.HEAPF32[place + axis] + centre[axis];
    }
    return frame;
  };
}

function enough(spent, total) {
  if (spent.length < FORESIGHT) return false;
  if (job.foresee) return ((total - spent[0]) / (spent.length - 1)) * job.frames > 1e3 * job.seconds;
  return total > 1e3 * job.seconds && spent.length >= 2 * FORESIGHT;
}

const milliseconds = ({ user, system }) => (user + system) / 1e3;
const jolt = world();
const body = addBody(jolt);
const read = reader(body);
const output = fs.openSync(job.output, 'w');
const start = milliseconds(process.cpuUsage());
const spent = [];
let total = 0;
while (spent.length < job.frames && !enough(spent, total)) {
  const before = process.cpuUsage();
  jolt.Step(1 / FPS, 1);
  spent.push(milliseconds(process.cpuUsage(before)));
  total += spent.at(-1);
  const frame = read();
  fs.writeSync(output, Buffer.from(frame.buffer));
  if (!frame.every(Number.isFinite)) break;
}
fs.closeSync(output);
fs.writeFileSync(job.report, JSON.stringify({ start_seconds: start / 1e3, cpu_ms: spent }));
process.exit(0);
