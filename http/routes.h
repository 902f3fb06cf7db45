// All routes of the server, in one list.
#ifndef CAIRN_HTTP_ROUTES_H_
#define CAIRN_HTTP_ROUTES_H_

#include "http/router.h"
#include "http/service/localize_service.h"

namespace cairn {

// The API and the pages; with `with_admin`, also the routes of AdminRoutes.
Router MainRoutes(LocalizeService* service, bool with_admin);

// Health and metrics.
Router AdminRoutes(LocalizeService* service);

}  // namespace cairn

#endif  // CAIRN_HTTP_ROUTES_H_
