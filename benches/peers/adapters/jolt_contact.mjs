// Jolt's soft body among bodies, compiled to WebAssembly: node jolt_contact.mjs JOB.json (the job: see harness.py).
// Its vertices collide with bodies; its cloth does not collide with itself.
// settings: iterations (Jolt takes that many substeps of one constraint pass each), compliance [m/N] of the edges.
// The edges are added by hand, as in jolt_cloth.mjs.
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';

const FPS = 60;
const WIDE = 5; // half of the width of the block whose top is the floor [m]
const FAR = 1e3; // as in harness.py
const job = JSON.parse(fs.readFileSync(process.argv[2], 'utf8'));
const require = createRequire(path.join(job.environment, 'here.js'));
const Jolt = await (await import(pathToFileURL(require.resolve('jolt-physics')))).default();

function world() {
  const settings = new Jolt.JoltSettings();
  const layers = new Jolt.ObjectLayerPairFilterTable(1);
  layers.EnableCollision(0, 0);
  const broad = new Jolt.BroadPhaseLayerInterfaceTable(1, 1);
  broad.MapObjectToBroadPhaseLayer(0, new Jolt.BroadPhaseLayer(0));
  settings.mObjectLayerPairFilter = layers;
  settings.mBroadPhaseLayerInterface = broad;
  settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(broad, 1, layers, 1);
  const jolt = new Jolt.JoltInterface(settings);
  jolt.GetPhysicsSystem().SetGravity(new Jolt.Vec3(0, 0, -9.81));
  return jolt;
}

function shapeOf(body) {
  if (body.kind === 'ball') return new Jolt.SphereShape(body.radius);
  const half = body.kind === 'floor' ? [WIDE, WIDE, WIDE] : body.half;
  return new Jolt.BoxShape(new Jolt.Vec3(...half), 0);
}

function addObstacle(bodies, body) {
  const [w, x, y, z] = body.quaternion ?? [1, 0, 0, 0];
  const centre = body.kind === 'floor' ? [0, 0, body.height - WIDE] : body.centre;
  const place = [new Jolt.RVec3(...centre), new Jolt.Quat(x, y, z, w)];
  const creation = new Jolt.BodyCreationSettings(shapeOf(body), ...place, Jolt.EMotionType_Static, 0);
  creation.mFriction = job.friction;
  bodies.AddBody(bodies.CreateBody(creation).GetID(), Jolt.EActivation_DontActivate);
}

function sheet() {
  const shared = new Jolt.SoftBodySharedSettings();
  const vertex = new Jolt.SoftBodySharedSettingsVertex();
  job.positions.forEach((position, index) => {
    vertex.mPosition = new Jolt.Float3(...position);
    vertex.mInvMass = 1 / job.masses[index];
    shared.mVertices.push_back(vertex);
  });
  for (const corners of job.triangles) shared.AddFace(new Jolt.SoftBodySharedSettingsFace(...corners, 0));
  for (const ends of job.edges) {
    shared.mEdgeConstraints.push_back(new Jolt.SoftBodySharedSettingsEdge(...ends, job.settings.compliance));
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
  creation.mFriction = job.friction;
  creation.mRestitution = 0;
  creation.mVertexRadius = job.thickness / 2;
  const bodies = jolt.GetPhysicsSystem().GetBodyInterface();
  for (const body of job.bodies) addObstacle(bodies, body);
  const body = bodies.CreateSoftBody(creation);
  bodies.AddBody(body.GetID(), Jolt.EActivation_Activate);
  return body;
}

// Positions of all vertices, read from the heap: they are relative to the body's centre.
function reader(body) {
  const motion = Jolt.castObject(body.GetMotionProperties(), Jolt.SoftBodyMotionProperties);
  const offset = Jolt.SoftBodyVertexTraits.prototype.mPositionOffset;
  const frame = new Float64Array(3 * job.positions.length);
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

const milliseconds = ({ user, system }) => (user + system) / 1e3;
const jolt = world();
const body = addBody(jolt);
const read = reader(body);
const output = fs.openSync(job.output, 'w');
const start = milliseconds(process.cpuUsage());
const spent = [];
let total = 0;
while (spent.length < job.frames && (total <= 1e3 * job.seconds || spent.length < job.least)) {
  const before = process.cpuUsage();
  jolt.Step(1 / FPS, 1);
  spent.push(milliseconds(process.cpuUsage(before)));
  total += spent.at(-1);
  const frame = read();
  fs.writeSync(output, Buffer.from(frame.buffer));
  if (!frame.every((place) => Math.abs(place) < FAR)) break;
}
fs.closeSync(output);
fs.writeFileSync(job.report, JSON.stringify({ start_seconds: start / 1e3, cpu_ms: spent }));
process.exit(0);
