// Vue's door to the sandwich tab.
export default {
  template: `<div class="mcdas mcdas-studio"></div>`,
  props: { look: Object, setup: Object },
  mounted() {
    document.querySelectorAll(".mcdas-loading").forEach((sign) => sign.remove());
    this.view = new window.mcdas.SandwichTab(this.$el, this.look, this.setup, (name, payload) => this.$emit(name, payload));
    this.$emit("ready", this.view.first);
  },
  methods: {
    hear(part) { this.view.hear(part); },
  },
};
