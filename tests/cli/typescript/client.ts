// A program against a server, with the types that openapi-typescript makes of openapi.json. The
// compiler refuses it if a member that it uses is missing in the description.
import createClient from "openapi-fetch";
import type { components, paths } from "./schema.js";

type Request = components["schemas"]["LocalizeRequest"];
type Pose = components["schemas"]["GeoPose"];

export interface Found {
  covered: boolean;
  tilesListed: number;
  firstTileHasLandmarks: boolean;
  pose: Pose | undefined;
  reason: string | null;
  codeOfRefusal: string | undefined;
}

export async function find(baseUrl: string, request: Request): Promise<Found> {
  const cairn = createClient<paths>({ baseUrl });
  const prior = request.prior?.position ?? { lat: 0, lon: 0 };
  const availability = await cairn.GET("/v1/availability", {
    params: { query: { lat: prior.lat, lon: prior.lon, accuracy: request.prior?.accuracy } },
  });
  const list = await cairn.GET("/v1/tiles", { params: { query: { limit: 10 } } });
  const tiles = list.data?.tiles ?? [];
  const tile = await cairn.GET("/v1/tiles/{id}", { params: { path: { id: tiles[0]?.id ?? "" } } });
  const answer = await cairn.POST("/v1/localize", { body: request });
  if (answer.data === undefined || !("status" in answer.data)) {
    throw new Error(JSON.stringify(answer.error));
  }
  const refused = await cairn.GET("/v1/tiles/{id}", { params: { path: { id: "nowhere" } } });
  return {
    covered: availability.data?.available ?? false,
    tilesListed: tiles.length,
    firstTileHasLandmarks: (tile.data?.landmarks ?? 0) > 0,
    pose: answer.data.geopose,
    reason: answer.data.reason,
    codeOfRefusal: refused.error?.code,
  };
}
