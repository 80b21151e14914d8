
# Names of demos, policies, objects and the like are asked of robocell.
_robocell_names() {
    local -a names
    names=(${(f)"$(robocell complete $1 -- ${words[@]} 2>/dev/null)"})
    compadd -a names
}
_robocell_demos() { _robocell_names demos }
_robocell_policies() { _robocell_names policies }
_robocell_objects() { _robocell_names objects }
_robocell_cells() { _robocell_names cells }
