// roslib hears joints in each packing, asks rosapi, runs a trajectory, and prints what came as JSON.
import * as ROSLIB from "roslib";

const ros = new ROSLIB.Ros({ url: process.argv[2] });
await new Promise((resolve, reject) => { ros.on("connection", resolve); ros.on("error", reject); });

const heard = {};
for (const compression of ["none", "cbor", "png"]) {
  const topic = new ROSLIB.Topic({ ros, name: "/arm/joint_states", messageType: "sensor_msgs/JointState", compression });
  heard[compression] = await new Promise((resolve) => topic.subscribe(resolve));
  topic.unsubscribe();
}
const topics = await new Promise((resolve, reject) => ros.getTopics(resolve, reject));
const plain = (message) => ({ name: [...message.name], position: [...message.position] });
console.log(JSON.stringify({
  topics: topics.topics,
  joints: Object.fromEntries(Object.entries(heard).map(([key, one]) => [key, plain(one)])),
}));
ros.close();
