-- A simulated run counts once, however often it was stored, and rates can be told apart by test, level and
-- friction.

ALTER TABLE simulation ADD COLUMN run_key TEXT;  -- runs of one key are one run; NULL: not known
CREATE INDEX simulation_by_run ON simulation (run_key);
ALTER TABLE holding ADD COLUMN begins_s REAL;    -- when the test's lift begins; NULL: not known

-- Runs of before are one run if they were made from the same scene and design in the same way.
UPDATE simulation SET run_key = (
  SELECT printf('before 4: scene %d, design %d, level %s, trial %d, then %s, full %s, set %s', simulation.scene_id,
                t.design_id, simulation.level, simulation.trial_number,
                coalesce(json_extract(p.parameters_json, '$.then'), ''),
                coalesce(json_extract(p.parameters_json, '$.full'), 0),
                coalesce(json_extract(p.parameters_json, '$.set'), ''))
  FROM trial t, provenance p WHERE t.id = simulation.trial_id AND p.id = simulation.provenance_id);

-- As before, and of a simulation the run, the test of holding ('none': it had none), level and friction.
DROP VIEW grasp_rate_input;
DROP VIEW judged_trial;
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
       coalesce(s.trusted, 1) AS trusted,
       s.run_key,
       CASE WHEN s.trial_id IS NOT NULL THEN coalesce(h.test, 'none') END AS test,
       s.level,
       s.friction
FROM trial t
JOIN design d ON d.id = t.design_id
JOIN gripper g ON g.id = t.gripper_id
JOIN object o ON o.id = t.object_id
JOIN medium m ON m.id = t.medium_id
LEFT JOIN rig r ON r.id = t.rig_id
LEFT JOIN outcome_current c ON c.trial_id = t.id
LEFT JOIN link_metrics l ON l.trial_id = t.id
LEFT JOIN track k ON k.trial_id = t.id
LEFT JOIN simulation s ON s.trial_id = t.id
LEFT JOIN holding h ON h.trial_id = t.id;

-- All trials that were judged and can count for a success rate, runs as often as they were stored.
CREATE VIEW judged_run AS
SELECT * FROM trial_overview
WHERE state IN ('recorded', 'degraded') AND NOT voided AND grasped IS NOT NULL;

-- The same with each run once, as it was stored last; also simulations that are not trusted.
CREATE VIEW judged_trial AS
SELECT * FROM judged_run
WHERE trial_id IN (SELECT max(trial_id) FROM judged_run GROUP BY coalesce(run_key, trial_id));

-- The trials that count for a success rate, one row each; group by kind too, or pick one.
CREATE VIEW grasp_rate_input AS
SELECT * FROM judged_trial WHERE trusted;
