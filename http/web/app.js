"use strict";

// Coverage on a canvas, the server's state, and a form that localizes a photo. No libraries.

const byId = (id) => document.getElementById(id);
const form = byId("form");
const state = {
  tiles: [],                          // Rings of [lon, lat], one a tile.
  view: { lon: 0, lat: 0, metersPerPixel: 1 },
  prior: null,                        // { lon, lat, accuracy }
  pose: null,                         // { lon, lat, headingDeg }
  cell: null,                         // The cell that the last answer named; a front divides by it.
};
const METERS_PER_DEGREE = 111320;

// --- API key -------------------------------------------------------------------------------------

// The browser keeps the key until the tab is closed. It is sent to this server only.
const KEY_NAME = "cairn-api-key";
const keyForm = byId("key-form");
keyForm.key.value = sessionStorage.getItem(KEY_NAME) ?? "";
keyForm.hidden = keyForm.key.value === "";

keyForm.addEventListener("submit", (event) => {
  event.preventDefault();
  const key = keyForm.key.value.trim();
  if (key === "") sessionStorage.removeItem(KEY_NAME);
  else sessionStorage.setItem(KEY_NAME, key);
  refresh();
});

// What fronts mean that answer in place of the server, with a page of their own.
const FRONT_ANSWERS = {
  413: "the photo is larger than the front of the server allows",
  502: "the front of the server does not reach the server",
  503: "the front of the server has no server that is ready",
  504: "the server took longer than its front waits",
};

// `body` is null if it is not JSON.
class ServerError extends Error {
  constructor(response, body) {
    const words = body === null
      ? [`status ${response.status}: ${FRONT_ANSWERS[response.status] ?? "the answer is not from this server"}`]
      : [body.detail || response.statusText, body.hint];
    super(words.filter(Boolean).join("\n"));
    this.status = response.status;
  }
}

async function readJson(response) {
  const body = await response.json().catch(() => null);
  if (!response.ok || body === null) throw new ServerError(response, body);
  return body;
}

// As fetch, with the key. Shows the field for the key if the server asks for one.
async function fetchWithKey(path, options = {}) {
  const key = sessionStorage.getItem(KEY_NAME);
  // A header may hold visible ASCII only; the browser refuses the rest in its own words.
  const headers = { ...options.headers, ...(key ? { Authorization: `Bearer ${key}` } : {}) };
  const response = await fetch(path, { ...options, headers });
  if (response.status === 401 || response.status === 403) keyForm.hidden = false;
  return response;
}

const getJson = async (path) => readJson(await fetchWithKey(path));

// --- Map -----------------------------------------------------------------------------------------

const map = byId("map");
const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);

// Local scale: meters per degree of longitude at the middle of the view.
const lonScale = () => METERS_PER_DEGREE * Math.max(0.01, Math.cos(state.view.lat * Math.PI / 180));

function toPixel([lon, lat]) {
  const { view } = state;
  return [
    map.width / 2 + (lon - view.lon) * lonScale() / view.metersPerPixel,
    map.height / 2 - (lat - view.lat) * METERS_PER_DEGREE / view.metersPerPixel,
  ];
}

function toLonLat(x, y) {
  const { view } = state;
  return [
    view.lon + (x - map.width / 2) * view.metersPerPixel / lonScale(),
    view.lat - (y - map.height / 2) * view.metersPerPixel / METERS_PER_DEGREE,
  ];
}

function drawScaleBar(context) {
  const target = 100 * state.view.metersPerPixel;
  const power = 10 ** Math.floor(Math.log10(target));
  const meters = power * (target / power >= 5 ? 5 : target / power >= 2 ? 2 : 1);
  const length = meters / state.view.metersPerPixel;
  context.fillStyle = color("--quiet");
  context.fillRect(12, map.height - 14, length, 2);
  context.font = "12px system-ui";
  context.fillText(meters >= 1000 ? `${meters / 1000} km` : `${meters} m`, 12, map.height - 20);
}

function drawPose(context) {
  const [x, y] = toPixel([state.pose.lon, state.pose.lat]);
  const heading = state.pose.headingDeg * Math.PI / 180;
  context.save();
  context.translate(x, y);
  context.rotate(heading);
  context.fillStyle = color("--accent");
  context.beginPath();
  context.moveTo(0, -14);
  context.lineTo(7, 8);
  context.lineTo(0, 4);
  context.lineTo(-7, 8);
  context.closePath();
  context.fill();
  context.restore();
}

function drawMap() {
  const context = map.getContext("2d");
  context.clearRect(0, 0, map.width, map.height);
  context.lineWidth = 1;
  context.strokeStyle = "#3f7f74";
  context.fillStyle = "#3f7f7455";
  for (const ring of state.tiles) {
    context.beginPath();
    ring.forEach((corner, i) => context[i === 0 ? "moveTo" : "lineTo"](...toPixel(corner)));
    context.closePath();
    context.fill();
    context.stroke();
  }
  if (state.prior) {
    const [x, y] = toPixel([state.prior.lon, state.prior.lat]);
    context.strokeStyle = color("--quiet");
    context.setLineDash([4, 4]);
    context.beginPath();
    context.arc(x, y, Math.max(3, state.prior.accuracy / state.view.metersPerPixel), 0, 7);
    context.stroke();
    context.setLineDash([]);
  }
  if (state.pose) drawPose(context);
  drawScaleBar(context);
}

function showAll() {
  const corners = state.tiles.flat();
  if (corners.length === 0) return;
  const lons = corners.map((corner) => corner[0]);
  const lats = corners.map((corner) => corner[1]);
  const range = (values) => values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)],
                                          [Infinity, -Infinity]);
  const [west, east] = range(lons);
  const [south, north] = range(lats);
  state.view.lon = (west + east) / 2;
  state.view.lat = (south + north) / 2;
  state.view.metersPerPixel = 1.15 * Math.max(
    (east - west) * lonScale() / map.width, (north - south) * METERS_PER_DEGREE / map.height, 0.2);
}

function eventPixel(event) {
  const box = map.getBoundingClientRect();
  return [(event.clientX - box.left) * map.width / box.width,
          (event.clientY - box.top) * map.height / box.height];
}

let drag = null;
map.addEventListener("pointerdown", (event) => {
  map.setPointerCapture(event.pointerId);
  drag = { start: eventPixel(event), anchor: toLonLat(...eventPixel(event)), moved: false };
});
map.addEventListener("pointermove", (event) => {
  if (!drag) return;
  const pixel = eventPixel(event);
  drag.moved ||= Math.hypot(pixel[0] - drag.start[0], pixel[1] - drag.start[1]) > 4;
  if (!drag.moved) return;
  const [lon, lat] = toLonLat(...pixel);
  state.view.lon += drag.anchor[0] - lon;
  state.view.lat += drag.anchor[1] - lat;
  drawMap();
});
map.addEventListener("pointerup", (event) => {
  if (drag && !drag.moved) {
    const [lon, lat] = toLonLat(...eventPixel(event));
    form.lat.value = lat.toFixed(6);
    form.lon.value = lon.toFixed(6);
    updatePrior();
  }
  drag = null;
});
map.addEventListener("wheel", (event) => {
  event.preventDefault();
  state.view.metersPerPixel *= Math.exp(event.deltaY * 0.001);
  drawMap();
}, { passive: false });

// --- Server --------------------------------------------------------------------------------------

const describeBytes = (bytes) =>
  bytes < 1e6 ? `${(bytes / 1e3).toFixed(0)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;

function showFacts(version) {
  const facts = {
    "Map version": version.map.version,
    Tiles: version.map.tiles.toLocaleString(),
    Landmarks: version.map.landmarks.toLocaleString(),
    Keyframes: version.map.keyframes.toLocaleString(),
    Payload: describeBytes(version.map.payloadBytes),
    Codec: version.map.codec ?? "none yet",
  };
  byId("facts").replaceChildren(...Object.entries(facts).flatMap(([name, value]) => {
    const term = document.createElement("dt");
    const detail = document.createElement("dd");
    term.textContent = name;
    detail.textContent = value;
    return [term, detail];
  }));
}

async function refresh() {
  const status = byId("status");
  try {
    const version = await getJson("version");
    const coverage = await getJson("v1/coverage?limit=10000");
    status.textContent = `running · version ${version.version}`;
    status.className = "";
    showFacts(version);
    const isFirst = state.tiles.length === 0;
    state.tiles = coverage.features.map((feature) => feature.geometry.coordinates[0]);
    if (isFirst) showAll();
    if (coverage.truncated) byId("map-note").textContent = "Only the first 10,000 tiles are shown.";
    drawMap();
  } catch (error) {
    const isAnswer = error instanceof ServerError;
    status.textContent = isAnswer ? error.message : `the server does not answer: ${error.message}`;
    status.className = "bad";
  }
}

// --- Photo ---------------------------------------------------------------------------------------

// What the fields take, beside a number: a unit, and the letters of the positive and the negative side.
const FIELDS = {
  lat: { label: "Latitude", unit: "°", sides: "NS", example: "48.94" },
  lon: { label: "Longitude", unit: "°", sides: "EW", example: "8.41" },
  accuracy: { label: "Accuracy", unit: "m", sides: "", example: "15" },
  focal: { label: "Focal length", unit: "px", sides: "", example: "1380" },
};

// The number in a text as people write it: "48,94", "−33.9", "48.94° N", "1380 px"; else NaN.
function parseNumber(name, text) {
  const { unit, sides } = FIELDS[name];
  const match = text.trim().replace("\u2212", "-")
    .match(/^([A-Za-z]?)\s*([-+]?)(\d+(?:[.,]\d*)?|[.,]\d+)\s*(°|px|m)?\s*([A-Za-z]?)$/);
  if (!match || (match[4] ?? unit) !== unit || (match[1] && match[5])) return NaN;
  const side = (match[1] + match[5]).toUpperCase();
  if (side !== "" && (!sides.includes(side) || match[2] !== "")) return NaN;
  const size = Number(match[3].replace(",", "."));
  return match[2] === "-" || (side !== "" && side === sides[1]) ? -size : size;
}

function number(name) {
  const text = form[name].value.trim();
  if (text === "") return null;
  const value = parseNumber(name, text);
  if (Number.isNaN(value)) {
    throw new Error(`${FIELDS[name].label}: "${text}" is not a number such as ${FIELDS[name].example}`);
  }
  return value;
}

// Divides "48.94, 8.41", which maps offer to copy, between the two fields.
function splitPair() {
  const text = form.lat.value.trim();
  if (text === "" || !Number.isNaN(parseNumber("lat", text))) return;
  for (const gap of text.matchAll(/\s*[,;]\s*|\s+/g)) {
    const [lat, lon] = [text.slice(0, gap.index), text.slice(gap.index + gap[0].length)];
    if (Number.isNaN(parseNumber("lat", lat)) || Number.isNaN(parseNumber("lon", lon))) continue;
    form.lat.value = lat;
    form.lon.value = lon;
    return;
  }
}

// The position in the form, or null; throws if the person has to mend the form.
function formPrior() {
  const [lat, lon, accuracy] = [number("lat"), number("lon"), number("accuracy")];
  if ((lat === null) !== (lon === null)) {
    const [given, missing] = lat === null ? ["Longitude", "latitude"] : ["Latitude", "longitude"];
    throw new Error(`${given} without ${missing}: give both or none`);
  }
  return lat === null ? null : { lat, lon, accuracy: accuracy ?? 15, source: "the form" };
}

function checkForm() {
  splitPair();
  formPrior();
  number("focal");
}

// The position of the form, else that of the photo's EXIF. None while somebody is typing the form.
function updatePrior(event) {
  if (event?.type === "change" || event?.inputType === "insertFromPaste") splitPair();
  try {
    state.prior = formPrior() ?? (form.exif.checked && exif.gps
      ? { ...exif.gps, source: "the photo's EXIF" } : null);
  } catch {
    state.prior = null;
  }
  byId("exif-note").textContent = !photo ? "" : !exif.gps ? "(this photo has none)"
    : `(${exif.gps.lat.toFixed(5)}°, ${exif.gps.lon.toFixed(5)}° ± ${exif.gps.accuracy.toFixed(0)} m)`;
  drawMap();
}

// A value of a TIFF directory: a function (tag, n) => number or text of one character, or undefined.
function tiffDirectory(view, little, offset) {
  const sizes = { 1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 13: 4 };
  const u32 = (at) => view.getUint32(at, little);
  const i32 = (at) => view.getInt32(at, little);
  const readers = { 1: (at) => view.getUint8(at), 2: (at) => String.fromCharCode(view.getUint8(at)),
                    3: (at) => view.getUint16(at, little), 4: u32, 5: (at) => u32(at) / u32(at + 4),
                    6: (at) => view.getInt8(at), 7: (at) => view.getUint8(at), 8: (at) => view.getInt16(at, little),
                    9: i32, 10: (at) => i32(at) / i32(at + 4),
                    11: (at) => view.getFloat32(at, little), 12: (at) => view.getFloat64(at, little), 13: u32 };
  return (tag, n = 0) => {
    if (offset + 2 > view.byteLength) return undefined;
    const count = Math.min(view.getUint16(offset, little), (view.byteLength - offset - 2) / 12);
    for (let i = 0; i + 1 <= count; ++i) {
      const entry = offset + 2 + 12 * i;
      if (view.getUint16(entry, little) !== tag) continue;
      const type = view.getUint16(entry + 2, little);
      const bytes = u32(entry + 4) * sizes[type];
      const at = bytes <= 4 ? entry + 8 : u32(entry + 8);
      if (!(bytes > n * sizes[type]) || at + bytes > view.byteLength) return undefined;
      const value = readers[type](at + n * sizes[type]);
      return type === 2 || Number.isFinite(value) ? value : undefined;
    }
    return undefined;
  };
}

// The position of a GPS directory, whose letters some writers give the types of bytes. None if the receiver marked it as void.
function positionOf(gps) {
  const letter = (tag) => {
    const value = gps(tag) ?? "";
    return (typeof value === "number" ? String.fromCharCode(value) : value).toUpperCase();
  };
  const angle = (tag, negative, max) => {
    const degrees = gps(tag) + (gps(tag, 1) ?? 0) / 60 + (gps(tag, 2) ?? 0) / 3600;
    if (!(degrees >= 0 && degrees <= max)) return undefined;
    return letter(tag - 1) === negative ? -degrees : degrees;
  };
  const lat = angle(2, "S", 90), lon = angle(4, "W", 180);
  if (lat === undefined || lon === undefined || (lat === 0 && lon === 0) || letter(9) === "V") return undefined;
  const stated = gps(0x1f);   // Meters; few phones state it.
  const accuracy = stated > 0 ? stated : 25;
  return accuracy <= 1e5 ? { lat, lon, accuracy } : undefined;
}

// The focal length for 35 mm film that an EXIF directory states or, as Canon's, tells by the sensor's resolution.
function focal35mmOf(camera) {
  const positive = (tag) => Math.max(0, camera(tag) ?? 0);
  if (positive(0xa405) > 0) return positive(0xa405);
  const focalMm = Math.max(1, camera(0xa404) ?? 1) * positive(0x920a);
  const across = positive(0xa20e), along = positive(0xa20f) || across;
  const unitMm = { 3: 10, 4: 1, 5: 0.001 }[camera(0xa210)] ?? 25.4;
  const sensorMm = unitMm * Math.max(positive(0xa002) / across, positive(0xa003) / along);
  return focalMm > 0 && sensorMm >= 3 && sensorMm <= 60 ? focalMm / sensorMm * 36 : undefined;
}

// Position and focal length from the TIFF structure of a photo's EXIF, as the server reads them
// (core/images/exif.cc). Undefined if there is no entry.
function readTags(view) {
  if (view.byteLength < 8) return undefined;
  const order = view.getUint16(0), little = order === 0x4949;
  if ((!little && order !== 0x4d4d) || view.getUint16(2, little) !== 42) return undefined;
  const start = view.getUint32(4, little);
  if (start + 14 > view.byteLength || view.getUint16(start, little) === 0) return undefined;
  const first = tiffDirectory(view, little, start);
  const gps = tiffDirectory(view, little, first(0x8825) ?? view.byteLength);
  const camera = tiffDirectory(view, little, first(0x8769) ?? view.byteLength);
  const focal35mm = focal35mmOf(camera);
  return { gps: positionOf(gps), focal35mm: focal35mm >= 4 && focal35mm <= 2000 ? focal35mm : undefined };
}

// Finds the EXIF in a JPEG or PNG file: the first block with entries. Shrinking a photo loses it. What old editors
// write into a PNG as text is left to the server.
function readExif(buffer) {
  const view = new DataView(buffer);
  const isSigned = (at, length) => length >= 6 && view.getUint32(at) === 0x45786966 && view.getUint16(at + 4) === 0;
  const block = (at, length) => isSigned(at, length) ? block(at + 6, length - 6)
    : readTags(new DataView(buffer, at, Math.min(length, 65536)));
  if (view.byteLength > 8 && view.getUint32(0) === 0x89504e47) {
    for (let at = 8; at + 12 <= view.byteLength; at += 12 + view.getUint32(at)) {
      const length = view.getUint32(at);
      const isExif = view.getUint32(at + 4) === 0x65584966 && at + 12 + length <= view.byteLength;
      const found = isExif ? block(at + 8, length) : undefined;
      if (found) return found;
    }
    return {};
  }
  for (let at = 2; at + 4 <= view.byteLength;) {
    const marker = view.getUint8(at + 1);
    const standsAlone = marker <= 1 || (marker >= 0xd0 && marker <= 0xd7);
    if (view.getUint8(at) !== 0xff || marker === 0xff || standsAlone) {
      ++at;   // Stray or fill bytes.
      continue;
    }
    if (marker === 0xda) break;
    const length = view.getUint16(at + 2);
    const isExif = marker === 0xe1 && at + 2 + length <= view.byteLength && isSigned(at + 4, length - 2);
    const found = isExif ? block(at + 4, length - 2) : undefined;
    if (found) return found;
    at += 2 + length;
  }
  return {};
}

const MAX_SIDE_PX = 1920;
let photo = null;      // ImageBitmap of the photo as turned by its EXIF; the request states this.
let photoScale = 1;    // Size of the bitmap divided by the size of the file.
let exif = {};         // What readExif found in the file.

async function loadPhoto(file) {
  try {
    exif = readExif(await file.arrayBuffer());
  } catch {
    exif = {};   // A damaged block is no block.
  }
  const original = await createImageBitmap(file);
  const side = Math.max(original.width, original.height);
  photoScale = Math.min(1, MAX_SIDE_PX / side);
  photo = await createImageBitmap(original, {
    resizeWidth: Math.round(original.width * photoScale), resizeQuality: "high" });
}

let loading = Promise.resolve();   // Rejected if the chosen file is not a photo.
form.photo.addEventListener("change", () => {
  const file = form.photo.files[0];
  photo = null;
  exif = {};
  updatePrior();
  byId("photo").hidden = true;
  byId("answer").hidden = true;
  if (!file) return;
  loading = loadPhoto(file).then(() => { drawPhoto([]); updatePrior(); }, () => {
    throw new Error(`${file.name} is not a photo that this browser can read; choose a JPEG or PNG file`);
  });
  loading.catch((error) => say(error.message));
});
for (const name of ["lat", "lon", "accuracy", "exif"]) {
  form[name].addEventListener("input", updatePrior);
  form[name].addEventListener("change", updatePrior);
}

function photoFile() {
  if (photoScale === 1) return form.photo.files[0];
  drawPhoto([]);
  return new Promise((done) => byId("photo").toBlob(done, "image/jpeg", 0.92));
}

function drawPhoto(matches) {
  const canvas = byId("photo");
  canvas.hidden = false;
  canvas.width = photo.width;
  canvas.height = photo.height;
  const context = canvas.getContext("2d");
  context.drawImage(photo, 0, 0);
  const radius = Math.max(2, photo.width / 250);
  context.lineWidth = radius / 2;
  for (const match of matches) {
    // Green is exact, red is 4 pixels off.
    context.strokeStyle = `hsl(${Math.max(0, 120 - 30 * match.error)} 90% 50%)`;
    context.beginPath();
    context.arc(match.u, match.v, radius, 0, 7);
    context.stroke();
  }
}

// The camera of the sent photo: the form's focal length, else the EXIF's, which is right within 5 %.
function cameraFor() {
  const size = [photo.width, photo.height];
  const pinhole = (focal) => ({
    model: "SIMPLE_PINHOLE", size, modelParams: [focal, photo.width / 2, photo.height / 2] });
  const focal = number("focal");
  if (focal !== null) return pinhole(focal * photoScale);
  if (!exif.focal35mm) return { size, focalLength: "unknown" };
  return { ...pinhole(exif.focal35mm / 36 * Math.max(...size)), focalLengthSigma: 0.05 };
}

function requestFor() {
  const request = {
    timestamp: Date.now(),
    camera: cameraFor(),
    options: { innerFrame: "FLU", timeoutMs: 10000, maxMatches: 2000, imageOrientation: "upright",
               exifPrior: false,   // The prior below is the EXIF's unless the person decides otherwise.
               include: ["matches", "timings"] },
  };
  if (state.prior) {
    request.prior = { position: { lat: state.prior.lat, lon: state.prior.lon },
                      accuracy: state.prior.accuracy };
  }
  return request;
}

// Describes the focal length of the answer, in pixels of the file.
function describeCamera(camera) {
  if (!camera) return [];
  const focal = (camera.focalLength / photoScale).toFixed(0);
  const accuracy = (camera.focalLengthAccuracy / photoScale).toFixed(0);
  const note = camera.focalLengthDisagrees ? ", contradicts the given value" : "";
  const part = camera.offCenter ? ["the photo was cut out of another"] : [];
  return [`focal length ${focal} ± ${accuracy} px${note}`, ...part];
}

function say(text) {
  byId("answer").hidden = false;
  byId("answer").textContent = text;
}

// Compass heading of the x axis (forward) of an FLU quaternion.
function headingDeg({ x, y, z, w }) {
  const east = 1 - 2 * (y * y + z * z);
  const north = 2 * (x * y + w * z);
  return (Math.atan2(east, north) * 180 / Math.PI + 360) % 360;
}

function describePrior(prior) {
  if (!prior) return "no prior";
  return `prior ${prior.lat.toFixed(5)}°, ${prior.lon.toFixed(5)}° ± ${prior.accuracy.toFixed(0)} m, from ${prior.source}`;
}

function describe(answer) {
  const times = Object.entries(answer.stages)
    .filter(([, stage]) => stage.ms !== undefined)
    .map(([name, stage]) => `${name} ${stage.ms.toFixed(1)}`).join(" · ");
  const prior = describePrior(state.prior);
  if (answer.status !== "LOCALIZED") {
    return `not localized: ${answer.reason}: ${answer.reasonText}\n${prior}\nms: ${times}`;
  }
  const { position, quaternion } = answer.geopose;
  return [
    `${position.lat.toFixed(7)}°, ${position.lon.toFixed(7)}°, ${position.h.toFixed(2)} m`,
    `heading ${headingDeg(quaternion).toFixed(1)}°`,
    `± ${answer.accuracy.position.toFixed(2)} m, ± ${answer.accuracy.orientation.toFixed(2)}° in the map`,
    `± ${answer.accuracyOnEarth.position.toFixed(2)} m on Earth`,
    ...describeCamera(answer.camera),
    `${answer.inlierCount} inliers, confidence ${answer.confidence.toFixed(2)}`,
    prior,
    `ms: ${times}`,
  ].join("\n");
}

async function localize() {
  await loading;
  checkForm();
  updatePrior();
  const body = new FormData();
  body.append("request", new Blob([JSON.stringify(requestFor())], { type: "application/json" }));
  body.append("image", await photoFile());
  const headers = state.cell ? { "X-Cairn-Cell": state.cell } : {};
  const response = await fetchWithKey("v1/localize", { method: "POST", headers, body });
  state.cell = response.headers.get("X-Cairn-Cell") ?? state.cell;
  return readJson(response);
}

form.addEventListener("submit", async (event) => {
  event.preventDefault();
  const button = form.querySelector("button");
  button.disabled = true;
  say("…");
  try {
    const answer = await localize();
    state.pose = answer.geopose
      ? { ...answer.geopose.position, headingDeg: headingDeg(answer.geopose.quaternion) } : null;
    drawPhoto(answer.matches ?? []);
    say(describe(answer));
    drawMap();
  } catch (error) {
    say(error.message);
  } finally {
    button.disabled = false;
  }
});

refresh();
setInterval(refresh, 15000);
