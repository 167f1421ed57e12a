"""The stages of a candidate after its proposal: driven, checked, costed, ended; and the choice between candidates."""
