-- How accurate each session is, as 68 % radii; docs/formats/map_v1.md. Maps of earlier programs lack
-- the table and get it with their next session. Earlier programs take it for a table of another
-- program, because its name does not begin with cairn_ and it has no checks.
CREATE TABLE session_accuracy (
  session_id   INTEGER NOT NULL PRIMARY KEY,
  in_map_m     REAL    NOT NULL,  -- Of poses in the map, beside what their matches predict.
  on_earth_m   REAL    NOT NULL,  -- Of the session's place on Earth.
  on_earth_rad REAL    NOT NULL   -- Of its direction on Earth.
) STRICT;

INSERT INTO gpkg_extensions VALUES
  ('session_accuracy', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write');
