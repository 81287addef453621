-- Simulated trials: the scene each was run from, and what the run says of itself.

CREATE TABLE scene (
  id      INTEGER PRIMARY KEY,
  name    TEXT NOT NULL,
  sha256  TEXT NOT NULL UNIQUE CHECK (length(sha256) = 64),
  toml    TEXT NOT NULL
) STRICT;

CREATE TABLE simulation (
  trial_id               TEXT PRIMARY KEY REFERENCES trial (id),
  provenance_id          INTEGER NOT NULL REFERENCES provenance (id),
  scene_id               INTEGER NOT NULL REFERENCES scene (id),
  level                  TEXT NOT NULL CHECK (level IN ('paper', 'standard', 'fast', 'static')),
  seed                   INTEGER NOT NULL,
  trial_number           INTEGER NOT NULL,  -- counts in the random draws, with the seed
  time_step_s            REAL NOT NULL,     -- taken; 0: equilibria without steps
  steps                  INTEGER NOT NULL,
  simulated_s            REAL NOT NULL,     -- reached
  wall_s                 REAL NOT NULL,
  terms_json             TEXT NOT NULL CHECK (json_valid(terms_json)),  -- what the plan switched on and why
  least_axis_distance_m  REAL,              -- of axes that touched; NULL: nothing did
  least_axis_share       REAL,              -- of the radii's sum
  longest_move_m         REAL,              -- of a node in a step
  nothing_passed         INTEGER CHECK (nothing_passed IN (0, 1)),  -- certificate; NULL: not looked at
  divergence             TEXT               -- why it stopped; NULL: it did not diverge
) STRICT;
CREATE INDEX simulation_by_scene ON simulation (scene_id);

CREATE VIEW simulation_overview AS
SELECT trial.label, scene.name AS scene, simulation.level, simulation.seed, simulation.trial_number,
       simulation.simulated_s, simulation.wall_s, simulation.nothing_passed, simulation.divergence,
       link_metrics.mutual_link, link_metrics.object_link, link_metrics.performance
FROM simulation
JOIN trial ON trial.id = simulation.trial_id
JOIN scene ON scene.id = simulation.scene_id
LEFT JOIN link_metrics ON link_metrics.trial_id = simulation.trial_id;
