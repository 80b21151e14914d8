
# Names of demos, policies, objects and the like are asked of robocell.
function __robocell_names
    robocell complete $argv[1] -- (commandline -opc) 2>/dev/null
end
complete -c robocell -n "__fish_seen_subcommand_from run load eval chaos show" -f -a "(__robocell_names demos)"
complete -c robocell -n "__fish_seen_subcommand_from drag" -f -a "(__robocell_names objects)"
complete -c robocell -n "__fish_seen_subcommand_from break" -f -a "(__robocell_names nodes)"
complete -c robocell -n "__fish_seen_subcommand_from logs" -f -a "(__robocell_names processes)"
complete -c robocell -l demo -x -a "(__robocell_names demos)"
complete -c robocell -l policy -x -a "(__robocell_names policies)"
complete -c robocell -l cell -x -a "(__robocell_names cells)"
