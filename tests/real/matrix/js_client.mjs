// A person at matrix-js-sdk, whose cryptography is that of Rust: what Element is made of.
// Usage: node js_client.mjs FOLDER_OF_PACKAGES
// Each line of standard input is {"id", "do", ...}, and is answered by a line {"id", "result"} or
// {"id", "error"}. With the end of the input it ends.
import { createHash, randomBytes, webcrypto } from "node:crypto";
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

// Part of Node from version 22 on.
Promise.withResolvers ??= () => {
  const parts = {};
  parts.promise = new Promise((resolve, reject) => Object.assign(parts, { resolve, reject }));
  return parts;
};
// What libraries say is for reading; lines of standard output are answers.
for (const level of ["debug", "info", "log", "trace"]) console[level] = console.error;

const [folder] = process.argv.slice(2);
const library = (path) => import(pathToFileURL(`${folder}/matrix-js-sdk/lib/${path}`).href);
const sdk = await library("index.js");
const crypto = await library("crypto-api/index.js");
const { logger } = await library("logger.js");
logger.setLevel("error", false);

const AES = "A256CTR";
const PHASES = ["", "unsent", "requested", "ready", "started", "cancelled", "done"];
let client;
const requests = new Map(); // of verification, by their transactions
const emoji = new Map(); // to compare, by transactions: what confirms them

const own = () => client.getCrypto();
const room = (id) => client.getRoom(id) ?? fail(`there is no room ${id} here`);
const fail = (why) => { throw new Error(why); };

// ---- the device ----

async function start({ url, user, password, device, strict = true, sign = true }) {
  const login = await sdk.createClient({ baseUrl: url }).loginRequest({
    type: "m.login.password",
    identifier: { type: "m.id.user", user },
    password,
    initial_device_display_name: device,
  });
  const { access_token: accessToken, user_id: userId, device_id: deviceId } = login;
  client = sdk.createClient({ baseUrl: url, accessToken, userId, deviceId });
  await client.initRustCrypto({ useIndexedDB: false });
  if (strict) own().setDeviceIsolationMode(new crypto.OnlySignedDevicesIsolationMode());
  client.on(crypto.CryptoEvent.VerificationRequestReceived, keep);
  const identifier = { type: "m.id.user", user: userId };
  const authUploadDeviceSigningKeys = (ask) => ask({ type: "m.login.password", identifier, password });
  if (sign) await own().bootstrapCrossSigning({ authUploadDeviceSigningKeys });
  await client.startClient({ initialSyncLimit: 1000, lazyLoadMembers: false });
  await new Promise((resolve) => {
    const look = (state) => { if (state === "PREPARED" || state === "SYNCING") resolve(); };
    client.on(sdk.ClientEvent.Sync, look);
    look(client.getSyncState());
  });
  return { user: userId, device: deviceId };
}

// ---- rooms ----

async function createRoom({ invite = [], encrypted = true, direct = false, name }) {
  const content = { algorithm: "m.megolm.v1.aes-sha2" };
  const created = await client.createRoom({
    ...(name && { name }),
    invite,
    is_direct: direct,
    preset: direct ? "trusted_private_chat" : "private_chat",
    initial_state: encrypted ? [{ type: "m.room.encryption", state_key: "", content }] : [],
  });
  return created.room_id;
}

const rooms = () => Object.fromEntries(client.getRooms().map((one) => [one.roomId, one.getMyMembership()]));
const members = ({ room: id }) => room(id).getJoinedMembers().map((member) => member.userId);

// ---- what a person does ----

async function send({ room: id, type = "m.room.message", content }) {
  return (await client.sendEvent(id, type, content)).event_id;
}

function say({ room: id, text, reply_to: reply, thread }) {
  const relation = {
    ...(thread && { rel_type: "m.thread", event_id: thread }),
    ...(reply && { "m.in_reply_to": { event_id: reply } }),
  };
  const content = { msgtype: "m.text", body: text };
  return send({ room: id, content: thread || reply ? { ...content, "m.relates_to": relation } : content });
}

function edit({ room: id, event, text }) {
  const content = { msgtype: "m.text", body: text };
  const relation = { rel_type: "m.replace", event_id: event };
  return send({ room: id, content: { ...content, body: `* ${text}`, "m.new_content": content, "m.relates_to": relation } });
}

function react({ room: id, event, key }) {
  return send({ room: id, type: "m.reaction", content: { "m.relates_to": { rel_type: "m.annotation", event_id: event, key } } });
}

const unpadded = (bytes) => Buffer.from(bytes).toString("base64").replace(/=+$/, "");
const counter = (iv) => ({ name: "AES-CTR", counter: iv, length: 64 });

async function sendFile({ room: id, name, base64, mime = "application/octet-stream" }) {
  const plain = Buffer.from(base64, "base64");
  const info = { mimetype: mime, size: plain.length };
  const content = { msgtype: mime.startsWith("image/") ? "m.image" : "m.file", body: name, filename: name, info };
  if (!(await own().isEncryptionEnabledInRoom(id))) {
    content.url = (await client.uploadContent(plain, { name, type: mime })).content_uri;
    return send({ room: id, content });
  }
  const key = await webcrypto.subtle.generateKey({ name: "AES-CTR", length: 256 }, true, ["encrypt", "decrypt"]);
  const iv = Buffer.concat([randomBytes(8), Buffer.alloc(8)]);
  const sealed = Buffer.from(await webcrypto.subtle.encrypt(counter(iv), key, plain));
  const { content_uri: url } = await client.uploadContent(sealed, { type: "application/octet-stream", includeFilename: false });
  const { k } = await webcrypto.subtle.exportKey("jwk", key);
  const sha256 = unpadded(createHash("sha256").update(sealed).digest());
  const jwk = { kty: "oct", key_ops: ["encrypt", "decrypt"], alg: AES, k, ext: true };
  content.file = { v: "v2", url, key: jwk, iv: unpadded(iv), hashes: { sha256 } };
  return send({ room: id, content });
}

// ---- what a person sees ----

async function told(event) {
  await client.decryptEventIfNeeded(event);
  const content = event.getContent();
  const shield = event.isEncrypted() ? await own().getEncryptionInfoForEvent(event) : null;
  return {
    id: event.getId(),
    sender: event.getSender(),
    kind: content.msgtype ?? event.getType(),
    text: content.body ?? "",
    encrypted: event.isEncrypted(),
    edited: Boolean(event.replacingEvent()),
    unreadable: event.decryptionFailureReason ?? "",
    shield: shield ? Object.keys(crypto.EventShieldColour).find((name) => crypto.EventShieldColour[name] === shield.shieldColour) : "",
    reply_to: event.replyEventId ?? "",
    content,
  };
}

// Edits and reactions are shown with what they belong to.
const shown = (event) =>
  ["m.room.message", "m.room.encrypted"].includes(event.getType()) && !event.isRedacted() && !event.isRelation("m.replace");

async function sees({ room: id }) {
  const found = room(id).getLiveTimeline().getEvents();
  const threads = room(id).getThreads().flatMap((thread) => thread.events);
  const events = [...new Map([...found, ...threads].map((event) => [event.getId(), event])).values()];
  await Promise.all(events.map((event) => client.decryptEventIfNeeded(event)));
  const messages = await Promise.all(events.filter(shown).map(told));
  return messages.map((message) => ({ ...message, reactions: reactions(id, message.id) }));
}

function reactions(id, event) {
  const relations = room(id).relations.getChildEventsForEvent(event, "m.annotation", "m.reaction");
  const sorted = relations?.getSortedAnnotationsByKey() ?? [];
  return Object.fromEntries(sorted.filter(([, who]) => who.size).map(([key, who]) => [key, [...who].map((one) => one.getSender())]));
}

async function file({ room: id, event }) {
  const { url, file: sealed } = room(id).findEventById(event).getContent();
  const address = client.mxcUrlToHttp(sealed?.url ?? url, undefined, undefined, undefined, false, true, true);
  const answer = await fetch(address, { headers: { Authorization: `Bearer ${client.getAccessToken()}` } });
  if (!answer.ok) fail(`the homeserver gives no file: ${answer.status}`);
  const bytes = Buffer.from(await answer.arrayBuffer());
  if (!sealed) return bytes.toString("base64");
  const sha256 = unpadded(createHash("sha256").update(bytes).digest());
  if (sha256 !== sealed.hashes.sha256) fail("the file is not what was sent");
  const key = await webcrypto.subtle.importKey("jwk", sealed.key, "AES-CTR", false, ["decrypt"]);
  const plain = await webcrypto.subtle.decrypt(counter(Buffer.from(sealed.iv, "base64")), key, bytes);
  return Buffer.from(plain).toString("base64");
}

// ---- trust ----

async function trust({ user, device }) {
  await own().getUserDeviceInfo([user], true);
  const status = await own().getUserVerificationStatus(user);
  const of = device ? await own().getDeviceVerificationStatus(user, device) : null;
  return {
    user_verified: status.isCrossSigningVerified(),
    needs_approval: status.needsUserApproval,
    signed_by_owner: Boolean(of?.signedByOwner),
    device_verified: Boolean(of?.isVerified()),
  };
}

async function devices({ user }) {
  const found = await own().getUserDeviceInfo([user], true);
  return [...(found.get(user)?.keys() ?? [])];
}

// ---- verification by emoji ----

function keep(request) {
  requests.set(request.transactionId, request);
  const follow = () => {
    const { verifier } = request;
    if (!verifier || verifier.followed) return;
    verifier.followed = true;
    verifier.on(crypto.VerifierEvent.ShowSas, (sas) => emoji.set(request.transactionId, sas));
    const ready = verifier.getShowSasCallbacks();
    if (ready) emoji.set(request.transactionId, ready);
    verifier.verify().catch(() => {}); // how it ended is asked of the request
  };
  request.on(crypto.VerificationRequestEvent.Change, follow);
  follow();
  return request.transactionId;
}

const request = (id) => requests.get(id) ?? fail(`there is no verification ${id}`);
const sas = (id) => emoji.get(id) ?? fail(`there are no emoji for ${id}`);

async function requestVerification({ user, room: id, device }) {
  await own().getUserDeviceInfo([user], true);
  return keep(id ? await own().requestVerificationDM(user, id) : await own().requestDeviceVerification(user, device));
}

const verifications = () => [...requests.values()].map((one) => ({
  transaction: one.transactionId,
  user: one.otherUserId,
  room: one.roomId ?? "",
  mine: one.initiatedByMe,
  phase: PHASES[one.phase],
  cancelled: one.cancellationCode ?? "",
  emoji: emoji.get(one.transactionId)?.sas.emoji?.map(([picture]) => picture) ?? [],
}));

const commands = {
  start,
  create_room: createRoom,
  rooms,
  members,
  invite: ({ room: id, user }) => client.invite(id, user).then(() => null),
  join: ({ room: id }) => client.joinRoom(id).then(() => null),
  leave: ({ room: id }) => client.leave(id).then(() => null),
  send,
  say,
  edit,
  react,
  redact: ({ room: id, event }) => client.redactEvent(id, event).then(() => null),
  send_file: sendFile,
  sees,
  file,
  trust,
  devices,
  rotate: ({ room: id }) => own().forceDiscardSession(id).then(() => null),
  request_verification: requestVerification,
  verifications,
  accept_verification: ({ transaction }) => request(transaction).accept().then(() => null),
  compare_emoji: ({ transaction }) => request(transaction).startVerification("m.sas.v1").then(() => null),
  confirm_emoji: ({ transaction }) => sas(transaction).confirm().then(() => null),
  reject_emoji: ({ transaction }) => sas(transaction).mismatch() ?? null,
  cancel_verification: ({ transaction }) => request(transaction).cancel().then(() => null),
};

const answer = (line) => process.stdout.write(`${JSON.stringify(line)}\n`);

async function carryOut({ id, do: name, ...given }) {
  try {
    const command = commands[name] ?? fail(`nothing is called ${name}`);
    answer({ id, result: (await command(given)) ?? null });
  } catch (error) {
    console.error(error);
    answer({ id, error: String(error.message ?? error) });
  }
}

for await (const line of createInterface({ input: process.stdin })) void carryOut(JSON.parse(line));
client?.stopClient();
process.exit(0);
