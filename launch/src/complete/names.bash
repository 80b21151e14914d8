
# Names of demos, policies, objects and the like are asked of robocell.
_robocell_names() {
    local cur=${COMP_WORDS[COMP_CWORD]} kind=
    case ${COMP_WORDS[COMP_CWORD - 1]} in
        run | load | eval | chaos | show | --demo) kind=demos ;;
        --policy) kind=policies ;;
        --cell) kind=cells ;;
        drag) kind=objects ;;
        break | --remove) kind=nodes ;;
        logs) kind=processes ;;
    esac
    if [[ -n $kind && $cur != -* ]]; then
        local IFS=$'\n'
        COMPREPLY=($(compgen -W "$(robocell complete "$kind" -- "${COMP_WORDS[@]:1}" 2>/dev/null)" -- "$cur"))
        [[ ${#COMPREPLY[@]} -gt 0 ]] && return
    fi
    _robocell "$@"
}
complete -F _robocell_names -o bashdefault -o default robocell
