#include "cli/options/cairn_options.h"

namespace cairn {
namespace {

void DescribeServer(ServerOptions* options, OptionList* list) {
  list->Add("num_threads", &options->num_threads,
            "Requests answered at once; 0 is 64, or four times the cores if that is more");
  list->Add(
      "max_waiting", &options->max_waiting,
      "Requests that wait for their turn at once; 0 is at most three quarters of the threads");
  list->Add("threads_per_query", &options->threads_per_query,
            "Threads that one query may use while cores are free; 0 is as many as cores");
  list->Add("keep_alive_s", &options->keep_alive_s,
            "Time for which a connection may be silent between requests, seconds");
  list->Add("cache_bytes", &options->cache_bytes, "Memory for decoded tiles, bytes");
  list->Add("max_body_bytes", &options->max_body_bytes, "Largest request, bytes");
  list->Add("max_image_pixels", &options->max_image_pixels,
            "Largest image as it is decoded, pixels. A JPEG may have 16 times as many and is then "
            "decoded at a smaller scale");
  list->Add("max_features", &options->max_features, "Most features of a request");
  list->Add("default_timeout_ms", &options->default_timeout_ms,
            "Time for a request that states no timeout, milliseconds");
  list->Add("max_timeout_ms", &options->max_timeout_ms,
            "Longest time for a request, whatever timeout it states, milliseconds");
}

void DescribeGeoregister(GeoregisterOptions* options, OptionList* list) {
  list->Add("up", &options->up, kUpSourceNames,
            "Which way is up: all that is known, the positions alone, the EXIF orientations, the "
            "side of the stored pictures at which up is, or down for photos that look straight "
            "down");
  list->Add("least_up_odds", &options->least_up_odds,
            "For auto: a direction that is less than this many times as likely as the next one is "
            "refused");
  list->Add("upright_sigma_rad", &options->upright_sigma_rad,
            "Standard deviation of the roll of photos, radians; 0 drops the assumption that photos "
            "are held level");
  list->Add("max_median_residual_sigmas", &options->max_median_residual_sigmas,
            "A fit with a larger median residual is refused, in units of the positions' accuracy");
  list->Add("max_median_residual_m", &options->max_median_residual_m,
            "A fit with a larger median residual is refused, meters; the default is three times "
            "the positions' accuracy, if that is more");
}

void DescribeNoise(PriorNoiseOptions* options, OptionList* list) {
  list->Add("position_sigma_m", &options->position_sigma_m,
            "Standard deviation of the position prior per horizontal axis, meters");
  list->Add("height_sigma_m", &options->height_sigma_m,
            "Standard deviation of the height of the prior, meters");
  list->Add("gravity_sigma_rad", &options->gravity_sigma_rad,
            "Standard deviation of the direction of gravity per axis, radians");
}

}  // namespace

void DescribeSift(SiftOptions* options, OptionList* list) {
  list->Add("max_features", &options->max_features,
            "Most features of a photo; those of the largest scales are kept");
  list->Add("max_pixels", &options->max_pixels,
            "A photo with more pixels is reduced to this many before extraction");
}

OptionList Describe(CairnOptions* options) {
  OptionList list("The sections from prior to answer are the stages of a query");
  DescribeLocalizer(&options->localizer, &list);
  list.AddSection("sift", "Features of photos; for serve, localize and eval",
                  [&] { DescribeSift(&options->sift, &list); });
  list.AddSection("server", "Limits of the server; for serve",
                  [&] { DescribeServer(&options->server, &list); });
  list.AddSection("ingest", "Which landmarks of a session enter the map; for ingest",
                  [&] { DescribeIngest(&options->ingest, &list); });
  list.AddSection("georegister", "How camera positions place a model; for map, ingest and eval",
                  [&] { DescribeGeoregister(&options->georegister, &list); });
  list.AddSection("mapping", "How photos become a model; for map",
                  [&] { DescribeMapping(&options->mapping, &list); });
  list.AddSection("noise", "Noise that turns true poses into priors; for eval",
                  [&] { DescribeNoise(&options->noise, &list); });
  return list;
}

void CairnOptions::Validate() const {
  localizer.Validate();
  sift.Validate();
  ServerOptions of_some_map = server;
  of_some_map.map_path = "map";
  of_some_map.Validate();
  IngestOptions of_some_session = ingest;
  of_some_session.session_name = "session";
  of_some_session.Validate();
  georegister.Validate();
  mapping.Validate();
  noise.Validate();
}

}  // namespace cairn
