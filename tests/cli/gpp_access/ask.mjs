// node ask.mjs REQUEST.json: sends a photo as clients of @oarc/gpp-access do and prints the answer, or
// what the client says of a refusal, as one line of JSON.
import {readFileSync} from 'node:fs';
import {register} from 'node:module';

register('./resolve.mjs', import.meta.url);
const gpp = await import('@oarc/gpp-access');

const ask = JSON.parse(readFileSync(process.argv[2], 'utf8'));
const image = readFileSync(ask.photo).toString('base64');
const privacy = new gpp.Privacy();
const now = Date.now();

const params = new gpp.CameraParam();
if (ask.modelParams) {
  params.model = gpp.CAMERAMODEL.PINHOLE;
  params.modelParams = ask.modelParams;
}
const request = new gpp.GeoPoseRequest('asked-by-npm')
    .addSensor(new gpp.Sensor('camera', gpp.SENSORTYPE.camera))
    .addSensor(new gpp.Sensor('gps', gpp.SENSORTYPE.geolocation))
    .addCameraData(gpp.IMAGEFORMAT.JPG, ask.size, image, 0, new gpp.ImageOrientation(false, 0),
                   params, now, 'camera', privacy)
    .addGeoLocationData(ask.lat, ask.lon, 0, ask.accuracy, 0, 0, 0, now, 'gps', privacy);
if (ask.acceleration) {
  request.addSensor(new gpp.Sensor('accelerometer', gpp.SENSORTYPE.accelerometer))
      .addAccelerometerData(...ask.acceleration, now, 'accelerometer', privacy);
}

try {
  console.log(JSON.stringify(await gpp.sendRequest(ask.url + '/geopose', JSON.stringify(request))));
} catch (error) {
  console.log(JSON.stringify({error: String(error)}));
}
