-- Views for people. Every map contains them, and they need no extension: the sqlite3 shell, DB
-- Browser and QGIS show them. Cairn itself does not read them.

-- Tiles, with everything that is known without decoding them.
CREATE VIEW v_tiles AS
SELECT c.tile,
       c.tile_id,
       c.num_landmarks,
       c.num_descriptors,
       c.num_keyframes,
       c.num_bytes,
       round(c.num_bytes * 1.0 / max(c.num_landmarks, 1), 1) AS bytes_per_landmark,
       c.min_h_m,
       c.max_h_m,
       t.payload_id,
       t.codebook_id,
       t.landmarks_south_deg,
       t.landmarks_west_deg,
       t.landmarks_north_deg,
       t.landmarks_east_deg
FROM coverage AS c
JOIN cairn_tiles AS t ON t.tile_id = c.tile_id;

-- Boxes around the tiles' squares, as stored in the index, which rounds them outwards by up to 2 m.
CREATE VIEW v_coverage AS
SELECT c.tile,
       c.tile_id,
       r.miny AS south_deg,
       r.minx AS west_deg,
       r.maxy AS north_deg,
       r.maxx AS east_deg,
       c.num_landmarks,
       c.num_keyframes
FROM coverage AS c
JOIN rtree_coverage_geom AS r ON r.id = c.tile_id;

-- Sessions, with the counts of their keyframes and tiles that are still in the map.
CREATE VIEW v_sessions AS
SELECT s.session_id,
       s.name,
       s.source,
       s.created_at,
       s.recorded_at,
       s.content_digest,
       s.num_images,
       s.num_landmarks,
       s.georef_median_residual_m,
       count(k.keyframe_id) AS num_keyframes,
       count(DISTINCT k.tile_id) AS num_tiles
FROM cairn_sessions AS s
LEFT JOIN keyframes AS k ON k.session_id = s.session_id
GROUP BY s.session_id;

-- Mapping images with position, heading and camera.
CREATE VIEW v_keyframes AS
SELECT k.keyframe_id,
       s.name AS session,
       k.image_name,
       k.tile_id,
       k.lat_deg,
       k.lon_deg,
       k.h_m,
       k.heading_deg,
       c.model AS camera_model,
       c.width_px,
       c.height_px,
       c.params AS camera_params
FROM keyframes AS k
JOIN cairn_sessions AS s ON s.session_id = k.session_id
JOIN cairn_keyframe_poses AS p ON p.keyframe_id = k.keyframe_id
JOIN cairn_cameras AS c ON c.camera_id = p.camera_id;

-- The whole map in one row.
CREATE VIEW v_map AS
SELECT m.format_version,
       m.created_at,
       v.version,
       v.num_sessions,
       v.num_keyframes,
       v.num_tiles,
       v.num_landmarks,
       v.num_descriptors,
       v.payload_bytes
FROM cairn_map AS m
JOIN cairn_versions AS v ON v.version = (SELECT max(version) FROM cairn_versions);

-- What each version did to each tile. The changes of the oldest version that is kept are not known.
CREATE VIEW v_changes AS
WITH states AS (
  SELECT t.tile_id, c.tile, t.since, NULL AS until, t.payload_id, c.num_landmarks, c.num_bytes
  FROM cairn_tiles AS t
  JOIN coverage AS c ON c.tile_id = t.tile_id
  UNION ALL
  SELECT tile_id, tile, since, until, payload_id, num_landmarks, num_bytes
  FROM cairn_past_tiles
), events AS (
  SELECT since AS version, tile_id, tile, payload_id AS new_payload_id, NULL AS old_payload_id,
         num_landmarks AS new_landmarks, 0 AS old_landmarks,
         num_bytes AS new_bytes, 0 AS old_bytes
  FROM states
  UNION ALL
  SELECT until, tile_id, tile, NULL, payload_id, 0, num_landmarks, 0, num_bytes
  FROM states
  WHERE until IS NOT NULL
)
SELECT version,
       tile,
       tile_id,
       CASE WHEN max(old_payload_id) IS NULL THEN 'added'
            WHEN max(new_payload_id) IS NULL THEN 'removed'
            ELSE 'replaced' END AS change,
       sum(old_landmarks) AS landmarks_before,
       sum(new_landmarks) AS landmarks_after,
       sum(old_bytes) AS bytes_before,
       sum(new_bytes) AS bytes_after,
       max(old_payload_id) AS payload_before,
       max(new_payload_id) AS payload_after
FROM events
WHERE version > (SELECT min(version) FROM cairn_versions)
GROUP BY version, tile_id;

-- Every version that was not pruned, with what it changed.
CREATE VIEW v_versions AS
SELECT v.version,
       v.created_at,
       v.author,
       v.kind,
       v.session,
       v.summary,
       coalesce(sum(c.change = 'added'), 0) AS tiles_added,
       coalesce(sum(c.change = 'replaced'), 0) AS tiles_replaced,
       coalesce(sum(c.change = 'removed'), 0) AS tiles_removed,
       v.num_sessions,
       v.num_keyframes,
       v.num_tiles,
       v.num_landmarks,
       v.num_descriptors,
       v.payload_bytes
FROM cairn_versions AS v
LEFT JOIN v_changes AS c ON c.version = v.version
GROUP BY v.version;
