#pragma once
// How a report looks: on a light and a dark screen, and on A4 paper. Plots keep their white ground.

namespace tendril::cli {

inline constexpr const char* kReportStyle = R"css(
:root { --ground: #ffffff; --text: #1c1c1c; --faint: #666666; --line: #d8d8d8; --note: #fff4d6; }
@media (prefers-color-scheme: dark) {
  :root { --ground: #16181a; --text: #e6e6e6; --faint: #a0a0a0; --line: #3c4043; --note: #3a3218; }
}
body { font: 15px/1.45 system-ui, "Helvetica Neue", Arial, sans-serif; background: var(--ground); color: var(--text);
  max-width: 1000px; margin: 0 auto; padding: 16px; }
h1 { font-size: 26px; margin: 0.2em 0 0.5em; overflow-wrap: anywhere; }
h2 { font-size: 19px; margin: 1.6em 0 0.4em; padding-bottom: 2px; border-bottom: 1px solid var(--line); }
h3 { font-size: 15px; margin: 1.2em 0 0.3em; }
table { border-collapse: collapse; font-size: 13px; margin: 0.4em 0; }
th, td { text-align: left; padding: 3px 12px 3px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
td { overflow-wrap: anywhere; }
th { font-weight: 600; }
.facts th { color: var(--faint); font-weight: 400; white-space: nowrap; }
.index td:nth-child(2) { min-width: 5.5em; }
.wide { overflow-x: auto; }
.wide td { overflow-wrap: normal; }
.note { color: var(--faint); font-size: 13px; margin: 0.4em 0; }
.remarks { background: var(--note); padding: 8px 12px 8px 30px; border-radius: 4px; font-size: 14px; }
.plots { display: grid; gap: 10px; margin: 8px 0; }
.pair { grid-template-columns: 1fr 1fr; }
figure { margin: 0; break-inside: avoid; }
.plot { background: #ffffff; border-radius: 4px; }
.plot svg { width: 100%; height: auto; display: block; }
.plot svg image { image-rendering: pixelated; }
.stills { display: grid; grid-template-columns: 1fr 1fr; gap: 10px; margin: 8px 0; align-items: end; }
.single { grid-template-columns: 1fr; }
.stills img { max-width: 100%; max-height: 480px; width: auto; height: auto; display: block; }
figcaption { font-size: 12px; color: var(--faint); }
.legend { white-space: nowrap; }
.key { display: inline-block; width: 18px; height: 4px; vertical-align: middle; }
footer { margin-top: 2em; font-size: 12px; color: var(--faint); }
a { color: inherit; }
@page { size: A4; margin: 14mm; }
@media print {
  :root { --ground: #ffffff; --text: #000000; --faint: #444444; --line: #c8c8c8; --note: #f4f4f4; }
  body { font-size: 10.5pt; max-width: none; padding: 0; }
  table { font-size: 9pt; }
  .stills img { max-height: 90mm; }
  h2, h3 { break-after: avoid; }
  tr { break-inside: avoid; }
  .key, .plot, .remarks { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
)css";

}  // namespace tendril::cli
