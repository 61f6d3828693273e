/** The phone's texts in English: one plain sentence each, that somebody in a mask and gloves understands at once. */

export const EN = {
  // which tag
  which_tag: "Which tag?",
  number_on_tag: "The number on the tag",
  where_am_i: "Where am I?",
  loading: "Loading.",
  tag: "Tag {tag}",

  // where am I
  you_are_at: "You are at tag {tag}.",
  next_to_it: "{far} {way} is tag {tag}",
  victims_near: { one: "{count} victim within {far}.", other: "{count} victims within {far}." },
  nearest_victim: "The nearest victim is {far} away.",
  no_victim: "No victim is known.",
  place_unsure: "Its place is known to {far} only.",
  lead_me_to: "Lead me to",
  victim: "Victim {victim}",
  no_way_known: "no way known",
  metres: "{n} m",
  about: "about {far}",
  north: "north", north_east: "north-east", east: "east", south_east: "south-east",
  south: "south", south_west: "south-west", west: "west", north_west: "north-west",
  count_0: "No", count_1: "One", count_2: "Two", count_3: "Three", count_4: "Four", count_5: "Five",
  count_6: "Six", count_7: "Seven", count_8: "Eight", count_9: "Nine",

  // the way there
  way_to: "The way to {goal}",
  to_goal: "To {goal}, {far} in all",
  goal_victim: "victim {name}", goal_tag: "tag {name}", goal_note: "note {name}",
  go: "go {far} {way}",
  turn_left: "turn left and go {far}", turn_right: "turn right and go {far}", turn_round: "turn round and go {far}",
  leg: "{pieces} to tag {tag}.",
  take_care: "Take care: {hazard}.",
  last_leg: "From tag {tag} go {far} {way}: there is {goal}.",
  there: "You are there: {goal}.",
  done: "Done",
  arrow: "Arrow, {degrees} degrees from north",
  to_tag: "to tag {tag}",
  to_the_victim: "to the victim", to_the_tag: "to the tag", to_the_note: "to the note",
  north_up: "The arrow points as on a map with north up.",
  i_am_at: "I am at {tag}",
  stop_leading: "Stop leading me",

  // leaving word
  leave_word: "Leave word here",
  what_is_here: "What is here",
  kind_hazard: "Hazard", kind_note: "Note", kind_searched: "Searched", kind_victim: "Victim",
  left_at: "{kind} left at tag {tag}.",
  not_sent: "Not sent. {why} Try again: it is kept once however often you send it.",

  // help
  mayday_hold: "MAYDAY: press and hold",
  mayday: "MAYDAY",
  mayday_called: "MAYDAY was called. Stay where you are if you can.",
  mayday_not_sent: "MAYDAY was NOT sent. {why}",
  evacuate: "EVACUATE. Everybody out, says {by}.",
  i_have_heard: "I have heard it",
};
