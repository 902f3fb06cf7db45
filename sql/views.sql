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
       (SELECT max(version) FROM cairn_versions) AS version,
       (SELECT count(*) FROM cairn_sessions) AS num_sessions,
       (SELECT count(*) FROM keyframes) AS num_keyframes,
       (SELECT count(*) FROM coverage) AS num_tiles,
       (SELECT coalesce(sum(num_landmarks), 0) FROM coverage) AS num_landmarks,
       (SELECT coalesce(sum(num_descriptors), 0) FROM coverage) AS num_descriptors,
       (SELECT coalesce(sum(num_bytes), 0) FROM coverage) AS payload_bytes
FROM cairn_map AS m;
