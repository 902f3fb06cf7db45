// POST /v1/localize and the GeoPoseProtocol at /geopose.
#ifndef CAIRN_HTTP_HANDLERS_LOCALIZE_HANDLERS_H_
#define CAIRN_HTTP_HANDLERS_LOCALIZE_HANDLERS_H_

#include "http/net/message.h"
#include "http/service/localize_service.h"

namespace cairn {

HttpResponse HandleLocalize(const HttpRequest& request, LocalizeService* service);
HttpResponse HandleGeoPose(const HttpRequest& request, LocalizeService* service);
HttpResponse HandleGeoPoseStatus();

}  // namespace cairn

#endif  // CAIRN_HTTP_HANDLERS_LOCALIZE_HANDLERS_H_
