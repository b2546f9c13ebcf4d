// What the official JavaScript client of rosbridge does, in a process of its own: one line for each.
// Usage: node roslibjs_client.mjs FOLDER_OF_ROSLIB URL KEY
import { pathToFileURL } from "node:url";

const [folder, url, key] = process.argv.slice(2);
const ROSLIB = await import(pathToFileURL(`${folder}/dist/RosLib.js`).href);
const MOST = 200;
const WITHIN_MS = 60_000;

const tell = (...words) => console.log(words.join(" "));
const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const within = (promise, what) =>
  Promise.race([promise, pause(WITHIN_MS).then(() => { throw new Error(`${what}: too late`); })]);
const until = async (holds, what) => {
  const end = Date.now() + WITHIN_MS;
  while (!holds()) {
    if (Date.now() > end) throw new Error(`${what}: too late`);
    await pause(20);
  }
};

const ros = new ROSLIB.Ros({});
await within(new Promise((resolve, reject) => {
  ros.on("connection", resolve);
  ros.on("error", reject);
  ros.connect(url).catch?.(reject);
}), "connect");
// Of the protocol's own op auth roslibjs sets the field mac: the key stands there.
ros.authenticate(key, "", "", "", 0, "", 0);

async function topics() {
  const found = await within(new Promise((resolve, reject) => ros.getTopics(resolve, reject)), "topics");
  tell("topics", ["/chatter", "/omni/odom", "/secret"].map((name) => found.topics.includes(name)).join(" "));
  const type = await within(new Promise((resolve, reject) => ros.getTopicType("/omni/odom", resolve, reject)), "type");
  tell("type", type);
}

async function chatter(compression) {
  const topic = new ROSLIB.Topic({ ros, name: "/chatter", messageType: "std_msgs/msg/String", compression });
  const heard = [];
  topic.subscribe((message) => heard.push(message.data));
  while (heard.length === 0) {
    topic.publish({ data: "first" });
    await pause(100);
  }
  await pause(300);
  heard.length = 0;
  for (let n = 0; n < MOST; n += 1) topic.publish({ data: `${n}` });
  await until(() => heard.length >= MOST, "chatter");
  tell("chatter", compression, heard.every((text, n) => text === `${n}`));
  topic.unsubscribe();
  topic.unadvertise();
  await pause(100);
}

async function drive() {
  const odometry = new ROSLIB.Topic({ ros, name: "/omni/odom", messageType: "nav_msgs/msg/Odometry", throttle_rate: 50 });
  const places = [];
  odometry.subscribe((message) => places.push(message.pose.pose.position.x));
  await until(() => places.length > 0, "odometry");
  const [begun, topic] = [places.at(-1), new ROSLIB.Topic({ ros, name: "/omni/cmd_vel", messageType: "geometry_msgs/msg/Twist" })];
  const end = Date.now() + WITHIN_MS;
  while (places.at(-1) - begun < 0.2 && Date.now() < end) {
    topic.publish({ linear: { x: 0.3, y: 0, z: 0 }, angular: { x: 0, y: 0, z: 0 } });
    await pause(50);
  }
  topic.publish({ linear: { x: 0, y: 0, z: 0 }, angular: { x: 0, y: 0, z: 0 } });
  await pause(1_000);
  const resting = places.at(-1);
  await pause(500);
  tell("drive", resting - begun >= 0.2, Math.abs(places.at(-1) - resting) < 0.005);
  odometry.unsubscribe();
}

async function goal() {
  const action = new ROSLIB.Action({ ros, name: "/omni/move", actionType: "rosic_interfaces/action/Move" });
  let fed = 0;
  const result = await within(new Promise((resolve, reject) => {
    action.sendGoal({ direction: "back", distance_m: 0.2, speed_m_s: 0.3 }, resolve, () => { fed += 1; }, reject);
  }), "goal");
  tell("goal", result.success, "fact_names" in result, fed > 0);
}

async function refused() {
  // A status with an id is told under that id, which roslibjs makes of the topic and a number.
  const said = [];
  const emit = ros.emit;
  ros.emit = function emitted(event, ...rest) {
    if (String(event).startsWith("status")) said.push(...rest);
    return emit.call(ros, event, ...rest);
  };
  new ROSLIB.Topic({ ros, name: "/omni/odom", messageType: "nav_msgs/msg/Odometry" }).publish({});
  await until(() => said.length > 0, "status");
  tell("refused", said[0].level);
}

async function stop() {
  const service = new ROSLIB.Service({ ros, name: "/omni/stop", serviceType: "std_srvs/srv/Trigger" });
  const answer = await within(new Promise((resolve, reject) => service.callService({}, resolve, reject)), "stop");
  tell("stop", answer.success);
}

for (const each of [topics, () => chatter("none"), () => chatter("png"), () => chatter("cbor"), drive, goal, refused, stop]) {
  await each();
}
ros.close();
tell("over");
process.exit(0);
