//! Colours and lines of the picture.

/// Style sheet.
pub(super) const STYLE: &str = "
text { font-family: system-ui, 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', sans-serif; fill: #23272e; font-size: 12px }
.page { fill: #f4f3ef } .card { fill: #ffffff; stroke: #dedbd3 } .plot { fill: #fbfaf7 }
.title { font-size: 24px; font-weight: 600 } .name { font-size: 16px; font-weight: 600 }
.small { fill: #6a6f78 } .right { text-anchor: end } .middle { text-anchor: middle }
.grid { fill: none; stroke: #e7e4dc; stroke-width: 1 } .axis { fill: none; stroke: #8b8f97; stroke-width: 1.2 }
.bound { fill: none; stroke: #8b8f97; stroke-width: 1.2; stroke-dasharray: 2 4 }
.mode { fill: none; stroke-width: 2.4; stroke-linejoin: round; stroke-linecap: round }
.later { fill: none; stroke-width: 1.2; stroke-dasharray: 1 4; stroke-opacity: 0.9 }
.peer { fill: #5d636d; stroke: #5d636d; stroke-width: 1.2 }
.best { fill: #c2185b; stroke: #ffffff; stroke-width: 1.2 } .best-line { fill: none; stroke: #c2185b; stroke-opacity: 0.45; stroke-width: 1; stroke-dasharray: 6 4 }
.peer-name { font-size: 10.5px; fill: #5d636d } .best-name { font-size: 11.5px; font-weight: 600; fill: #c2185b }
.peer-name, .best-name { paint-order: stroke; stroke: #fbfaf7; stroke-width: 3px; stroke-linejoin: round }
.leader { fill: none; stroke: #a9adb4; stroke-width: 0.8 }
.m0 { stroke: #0072b2 } .m1 { stroke: #e69f00 } .m2 { stroke: #009e73 } .m3 { stroke: #d55e00 }
.m4 { stroke: #7b3fa0 } .m5 { stroke: #56b4e9 } .m6 { stroke: #4d4d4d }
";
/// Colours in the style sheet.
const COLOURS: usize = 7;

/// Class of a mode's line: colours go round.
pub(super) fn mode_class(kind: &str, index: usize) -> String {
    format!("{kind} m{}", index % COLOURS)
}
