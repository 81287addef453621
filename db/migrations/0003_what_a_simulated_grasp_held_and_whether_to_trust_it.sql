-- Whether a simulation can be trusted, what it was run with, and how the grasp that it made was tested.

ALTER TABLE simulation ADD COLUMN trusted INTEGER NOT NULL DEFAULT 1 CHECK (trusted IN (0, 1));
ALTER TABLE simulation ADD COLUMN doubts TEXT NOT NULL DEFAULT '';  -- why it is not trusted, one a line
ALTER TABLE simulation ADD COLUMN longest_stick_share REAL;  -- spring of what sticks, of the radii's sum
ALTER TABLE simulation ADD COLUMN friction REAL;             -- of the scene's contact; NULL: not known
ALTER TABLE simulation ADD COLUMN medium TEXT;               -- as the trial's; NULL: not known

-- Runs of before, by the rule of now: overlaps up to a quarter of a radius.
UPDATE simulation SET trusted = 0, doubts = 'a body may have passed through another' WHERE nothing_passed = 0;
UPDATE simulation
SET trusted = 0,
    doubts = doubts || CASE WHEN doubts = '' THEN '' ELSE char(10) END ||
             printf('bodies overlap by %.0f %% of a radius', 200 * (1 - least_axis_share))
WHERE least_axis_share < 0.875;
UPDATE simulation
SET trusted = 0, doubts = doubts || CASE WHEN doubts = '' THEN '' ELSE char(10) END || 'it diverged'
WHERE divergence IS NOT NULL;

-- A test of holding that a simulation ended with (model/scene/holding.h).
CREATE TABLE holding (
  trial_id              TEXT PRIMARY KEY REFERENCES simulation (trial_id) ON DELETE CASCADE,
  test                  TEXT NOT NULL CHECK (test IN ('lift', 'load', 'strike', 'release')),
  lifted                INTEGER NOT NULL CHECK (lifted IN (0, 1)),  -- rose with the carrier and stayed
  held                  INTEGER NOT NULL CHECK (held IN (0, 1)),    -- what the test asks; release: let go
  rise_m                REAL,     -- the least above its start after the lift
  shift_m               REAL,     -- the most from where it hung after the lift
  payload_kg            REAL,     -- load: the object and what slipped it; NULL: not lifted, or another test
  payload_is_least      INTEGER NOT NULL CHECK (payload_is_least IN (0, 1)),  -- the largest load did not slip it
  payload_by_rods_mass  REAL,
  strikes               INTEGER,  -- strike: that it withstood
  release_s             REAL,     -- release: from the start of unwinding; NULL: not let go
  rule                  TEXT NOT NULL CHECK (rule <> '')  -- what counts as success, in words
) STRICT;

DROP VIEW simulation_overview;
CREATE VIEW simulation_overview AS
SELECT trial.label, scene.name AS scene, simulation.level, simulation.seed, simulation.trial_number,
       simulation.friction, simulation.medium, simulation.simulated_s, simulation.wall_s,
       simulation.trusted, simulation.doubts, simulation.nothing_passed, simulation.least_axis_share,
       simulation.longest_stick_share, simulation.divergence,
       holding.test, holding.lifted, holding.held, holding.rise_m, holding.shift_m, holding.payload_kg,
       holding.payload_is_least, holding.payload_by_rods_mass, holding.strikes, holding.release_s,
       outcome_current.grasped,
       link_metrics.mutual_link, link_metrics.object_link, link_metrics.performance
FROM simulation
JOIN trial ON trial.id = simulation.trial_id
JOIN scene ON scene.id = simulation.scene_id
LEFT JOIN holding ON holding.trial_id = simulation.trial_id
LEFT JOIN outcome_current ON outcome_current.trial_id = simulation.trial_id
LEFT JOIN link_metrics ON link_metrics.trial_id = simulation.trial_id;

-- As before, and whether a trial's simulation can be trusted (1 of trials that are none).
DROP VIEW grasp_rate_input;
DROP VIEW trial_overview;
CREATE VIEW trial_overview AS
SELECT t.id AS trial_id,
       t.label,
       t.kind,
       t.state,
       EXISTS (SELECT 1 FROM void v WHERE v.trial_id = t.id) AS voided,
       strftime('%Y-%m-%d %H:%M:%S', t.started_ns / 1000000000, 'unixepoch') AS started_utc,
       d.label AS design,
       d.taper,
       d.spacing_ratio,
       d.alpha_deg,
       d.beta_deg,
       g.tentacles,
       g.carrier_radius_m,
       g.handedness,
       o.label AS object,
       o.kind AS object_kind,
       o.radius_m AS object_radius_m,
       o.mass_kg AS object_mass_kg,
       m.name AS medium,
       r.label AS rig,
       t.object_distance_m AS distance_m,
       t.pull,
       t.pull_rate_per_s,
       c.grasped,
       c.judged_by,
       c.by_person,
       c.method,
       c.load_N,
       l.mutual_link,
       l.object_link,
       l.performance,
       k.rms_reprojection_px,
       k.seen_fraction,
       t.started_ns,
       coalesce(s.trusted, 1) AS trusted
FROM trial t
JOIN design d ON d.id = t.design_id
JOIN gripper g ON g.id = t.gripper_id
JOIN object o ON o.id = t.object_id
JOIN medium m ON m.id = t.medium_id
LEFT JOIN rig r ON r.id = t.rig_id
LEFT JOIN outcome_current c ON c.trial_id = t.id
LEFT JOIN link_metrics l ON l.trial_id = t.id
LEFT JOIN track k ON k.trial_id = t.id
LEFT JOIN simulation s ON s.trial_id = t.id;

-- The trials that were judged and can count for a success rate, also simulations that are not trusted.
CREATE VIEW judged_trial AS
SELECT * FROM trial_overview
WHERE state IN ('recorded', 'degraded') AND NOT voided AND grasped IS NOT NULL;

-- The trials that count for a success rate, one row each; group by kind too, or pick one.
CREATE VIEW grasp_rate_input AS
SELECT * FROM judged_trial WHERE trusted;
