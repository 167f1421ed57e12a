// Vue's door to the parking tab.
export default {
  template: `<div class="mcdas mcdas-studio"></div>`,
  mounted() {
    const { look, parking } = window.mcdas.setup;
    this.view = new window.mcdas.ParkingTab(this.$el, look, parking, (name, payload) => this.$emit(name, payload));
    this.$emit("ready", {});
  },
  methods: {
    hear(part) { this.view.hear(part); },
  },
};
