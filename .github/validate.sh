#!/usr/bin/env bash
# What the action in action.yml does: a study with candidates and limits, its summary on the job's page, and its result.
# Its inputs are variables of the environment. It ends with the exit code of `nephroid validate`: 1 if a figure is above
# its limit or the study is incomplete, 2 if it could not be made.
set -euo pipefail

arguments=("$STUDY" --output "$OUTPUT")
# One value a line, without empty lines: values may hold spaces.
add() {
    local flag="$1" value
    while IFS= read -r value; do
        value="${value%$'\r'}"
        if [[ -n "${value//[[:space:]]/}" ]]; then
            arguments+=(${flag:+"$flag"} "$value")
        fi
    done <<<"$2"
}
add --candidate "${CANDIDATE:-}"
add --max-error "${MAX_ERROR:-}"
add "" "${ARGUMENTS:-}"

# What an earlier run left is no result of this one.
rm -f "$OUTPUT"/{summary.md,poses.md,report.json,report.csv,poses.json,index.html}
code=0
"$NEPHROID" validate "${arguments[@]}" || code=$?
# Without a report, as with --list or --shard, no limit was judged.
if [[ $code = 0 && ! -f "$OUTPUT/summary.md" && ! -f "$OUTPUT/poses.md" ]]; then
    echo "no report was written"
    code=2
fi
case "$code" in
    0) result=kept ;;
    1) result=exceeded
       echo "::error title=nephroid::A figure is above its limit, or the study is incomplete" ;;
    *) result=failed
       echo "::error title=nephroid::The study could not be made" ;;
esac
echo "result=$result" >> "$GITHUB_OUTPUT"
for summary in "$OUTPUT/poses.md" "$OUTPUT/summary.md"; do
    if [[ -f "$summary" ]]; then
        cat "$summary" >> "$GITHUB_STEP_SUMMARY"
    fi
done
exit "$code"
