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

async function getJson(path) {
  const response = await fetch(path);
  const body = await response.json();
  if (!response.ok) throw new Error(body.detail || response.statusText);
  return body;
}

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
    const version = await getJson("/version");
    const coverage = await getJson("/v1/coverage?limit=10000");
    status.textContent = `running · version ${version.version}`;
    status.className = "";
    showFacts(version);
    const isFirst = state.tiles.length === 0;
    state.tiles = coverage.features.map((feature) => feature.geometry.coordinates[0]);
    if (isFirst) showAll();
    if (coverage.truncated) byId("map-note").textContent = "Only the first 10,000 tiles are shown.";
    drawMap();
  } catch (error) {
    status.textContent = `the server does not answer: ${error.message}`;
    status.className = "bad";
  }
}

// --- Photo ---------------------------------------------------------------------------------------

function number(name) {
  const text = form[name].value.trim();
  return text === "" ? null : Number(text.replace(",", "."));
}

function updatePrior() {
  const [lat, lon] = [number("lat"), number("lon")];
  state.prior = lat === null || lon === null ? null
    : { lat, lon, accuracy: number("accuracy") ?? 15 };
  drawMap();
}

const MAX_SIDE_PX = 1920;
let photo = null;      // ImageBitmap of the photo as turned by its EXIF; the request states this.
let photoScale = 1;    // Size of the bitmap divided by the size of the file.

async function loadPhoto(file) {
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
  byId("photo").hidden = true;
  byId("answer").hidden = true;
  if (!file) return;
  loading = loadPhoto(file).then(() => drawPhoto([]), () => {
    throw new Error(`${file.name} is not a photo that this browser can read; choose a JPEG or PNG file`);
  });
  loading.catch((error) => say(error.message));
});
for (const name of ["lat", "lon", "accuracy"]) form[name].addEventListener("input", updatePrior);

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

function requestFor() {
  const focal = number("focal");
  const size = [photo.width, photo.height];
  const request = {
    timestamp: Date.now(),
    camera: focal === null ? { size, focalLength: "unknown" } : {
      model: "SIMPLE_PINHOLE",
      size,
      modelParams: [focal * photoScale, photo.width / 2, photo.height / 2],
    },
    options: { innerFrame: "FLU", timeoutMs: 10000, maxMatches: 2000, imageOrientation: "upright",
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
  return [`focal length ${focal} ± ${accuracy} px${note}`];
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

function describe(answer) {
  const times = Object.entries(answer.stages)
    .filter(([, stage]) => stage.ms !== undefined)
    .map(([name, stage]) => `${name} ${stage.ms.toFixed(1)}`).join(" · ");
  if (answer.status !== "LOCALIZED") return `not localized: ${answer.reason}\nms: ${times}`;
  const { position, quaternion } = answer.geopose;
  return [
    `${position.lat.toFixed(7)}°, ${position.lon.toFixed(7)}°, ${position.h.toFixed(2)} m`,
    `heading ${headingDeg(quaternion).toFixed(1)}°`,
    `± ${answer.accuracy.position.toFixed(2)} m, ± ${answer.accuracy.orientation.toFixed(2)}°`,
    ...describeCamera(answer.camera),
    `${answer.inlierCount} inliers, confidence ${answer.confidence.toFixed(2)}`,
    `ms: ${times}`,
  ].join("\n");
}

async function localize() {
  await loading;
  const body = new FormData();
  body.append("request", new Blob([JSON.stringify(requestFor())], { type: "application/json" }));
  body.append("image", await photoFile());
  const headers = state.cell ? { "X-Cairn-Cell": state.cell } : {};
  const response = await fetch("/v1/localize", { method: "POST", headers, body });
  state.cell = response.headers.get("X-Cairn-Cell") ?? state.cell;
  const answer = await response.json();
  if (!response.ok) throw new Error([answer.detail, answer.hint].filter(Boolean).join("\n"));
  return answer;
}

form.addEventListener("submit", async (event) => {
  event.preventDefault();
  const button = form.querySelector("button");
  updatePrior();
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
