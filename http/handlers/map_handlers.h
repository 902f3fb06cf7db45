// Endpoints that describe the map: availability, coverage, tiles. Lists and payloads wait for their
// turn (LocalizeService::WaitForTurn), so that requests for them cannot take more than their share
// of cores and memory.
#ifndef CAIRN_HTTP_HANDLERS_MAP_HANDLERS_H_
#define CAIRN_HTTP_HANDLERS_MAP_HANDLERS_H_

#include <string>

#include "http/net/message.h"
#include "http/service/localize_service.h"

namespace cairn {

// GET /v1/availability?lat&lon[&accuracy]: the tiles that a query with this prior would search, and
// the name of its cell.
HttpResponse HandleAvailability(const HttpRequest& request, const LocalizeService& service);
// GET /v1/coverage[?bbox=w,s,e,n][&limit][&after]: GeoJSON squares of the tiles.
HttpResponse HandleCoverage(const HttpRequest& request, LocalizeService* service);
// GET /v1/tiles[?bbox][&limit][&after]
HttpResponse HandleTiles(const HttpRequest& request, LocalizeService* service);
// GET /v1/versions[?limit]: the versions of the map, newest first.
HttpResponse HandleVersions(const HttpRequest& request, LocalizeService* service);
// GET /v1/tiles/{id}, with ETag.
HttpResponse HandleTile(const HttpRequest& request, const std::string& id,
                        const LocalizeService& service);
// GET /v1/tiles/{id}/payload: the bytes of docs/formats/tile_v1.md, with ETag.
HttpResponse HandleTilePayload(const HttpRequest& request, const std::string& id,
                               LocalizeService* service);

}  // namespace cairn

#endif  // CAIRN_HTTP_HANDLERS_MAP_HANDLERS_H_
