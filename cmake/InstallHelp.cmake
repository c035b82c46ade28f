# Makes manual pages and bash completion of what the installed programs say of themselves.
# Set by Install.cmake: programs, bin, man, completions, awk, version.
set(titles_flusi "flow around insects with flexible wings")
set(titles_msm_train "trains the stiffness of a wing until it bends as measured")
set(titles_msm_diagnose "names what a wing model gets wrong about measured bending")
foreach(program ${programs})
  execute_process(COMMAND "$ENV{DESTDIR}${bin}/${program}" --help OUTPUT_VARIABLE help RESULT_VARIABLE failed ERROR_QUIET)
  if(failed OR help STREQUAL "")
    message(WARNING "${program} does not run on this machine: no manual page and no completion are installed for it")
    continue()
  endif()
  set(text "$ENV{DESTDIR}${man}/${program}.1.help")
  file(WRITE "${text}" "${help}")
  execute_process(COMMAND awk -v "name=${program}" -v "version=${version}" -v "title=${titles_${program}}" -f "${awk}" "${text}"
                  OUTPUT_FILE "$ENV{DESTDIR}${man}/${program}.1" COMMAND_ERROR_IS_FATAL ANY)
  file(REMOVE "${text}")
  string(REGEX MATCHALL "--[a-z][-a-z]*=?" options "${help}")
  list(REMOVE_DUPLICATES options)
  list(SORT options)
  string(JOIN " " options ${options})
  file(WRITE "$ENV{DESTDIR}${completions}/${program}" "# bash completion of ${program}: options and input files
_complete_${program}() {
  local word=\"\${COMP_WORDS[COMP_CWORD]}\"
  if [[ \"$word\" == -* ]]; then
    COMPREPLY=(\$(compgen -W \"${options}\" -- \"$word\"))
  else
    COMPREPLY=(\$(compgen -d -S / -- \"$word\") \$(compgen -f -X '!*.@(ini|h5|key)' -- \"$word\"))
  fi
}
complete -o nospace -o filenames -F _complete_${program} ${program}
")
endforeach()
