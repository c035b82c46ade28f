# Makes a manual page of what --help prints. Set: name, version, title.
function plain(text) { gsub(/\\/, "\\\\", text); gsub(/-/, "\\-", text); sub(/^['.]/, "\\\\\\&&", text); return text }
function section(wanted) { if (inside != wanted) { if (verbatim) { print ".fi"; verbatim = 0 } print ".SH " wanted; inside = wanted } }
function as_it_is() { if (!verbatim) { print ".nf"; verbatim = 1 } }
BEGIN {
  printf ".TH %s 1 \"\" \"flusi\\-msm %s\" \"flusi\\-msm\"\n", toupper(name), plain(version)
  print ".SH NAME\n" plain(name) " \\- " plain(title)
}
/^usage: /           { section("SYNOPSIS"); as_it_is(); sub(/^usage: /, ""); print plain($0); next }
/^       [a-z]/      { section(inside == "OPTIONS" || inside == "OTHER USES" ? "OTHER USES" : "SYNOPSIS"); as_it_is(); sub(/^ +/, ""); print plain($0); next }
/^  --[a-z]/         { section("OPTIONS"); at = match($0, /[^ ]  +[^ ]/)
                       if (at) { option = substr($0, 3, at - 2); text = substr($0, at + 1); sub(/^ +/, "", text) }
                       else { option = substr($0, 3); text = "" }
                       print ".TP\n.B " plain(option); if (text != "") print plain(text); next }
/^exit codes: /      { section("EXIT STATUS"); as_it_is(); sub(/^exit codes: /, ""); print plain($0); next }
inside == "EXIT STATUS" && /^          / { print plain(substr($0, 13)); next }
/^parameters: /      { section("SEE ALSO"); print plain($0); next }
/^ *$/               { next }
                     { if (inside == "OPTIONS" && $0 ~ /^ /) { sub(/^ +/, ""); print plain($0) } else print plain($0) }
